// Boost.odeint on the dimer chain: one line of JSON with a row for every setting.
//
// Run by odeint.py: odeint KAPPA SITES RUNS LONGEST_S TIMES EXACT
// TIMES, EXACT: float64, sample times and velocities (time, site).

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

#include <boost/numeric/odeint.hpp>

namespace odeint = boost::numeric::odeint;
using State = std::vector<double>;

struct Chain {
    std::vector<double> coefficient;
    mutable State force;

    // Accelerations `a` at displacements `x`, both of n places.
    void accelerate(const double *__restrict x, double *__restrict a) const {
        const size_t n = coefficient.size();
        const double *__restrict c = coefficient.data();
        double *__restrict f = force.data();
        for (size_t j = 0; j + 1 < n; j++) {
            const double overlap = std::max(x[j] - x[j + 1], 0.0);
            f[j] = c[j] * overlap * std::sqrt(overlap);
        }
        const double last = std::max(x[n - 1], 0.0);
        f[n - 1] = c[n - 1] * last * std::sqrt(last);
        a[0] = -f[0];
        for (size_t j = 1; j < n; j++) a[j] = f[j - 1] - f[j];
    }
};

// x' = v, v' = a(x) in one state: displacements, then velocities.
struct FirstOrder {
    const Chain &chain;
    void operator()(const State &y, State &dy, double) const {
        const size_t n = chain.coefficient.size();
        std::copy(y.begin() + n, y.end(), dy.begin());
        chain.accelerate(y.data(), dy.data() + n);
    }
};

struct Forces {
    const Chain &chain;
    void operator()(const State &x, State &a) const { chain.accelerate(x.data(), a.data()); }
};

struct Bench {
    int runs;
    double longest;
    std::vector<double> times, exact;
    size_t n;
    double kappa;

    using Keep = std::function<void(const double *)>;

    void measure(const char *scheme, const std::string &setting,
                 const std::function<void(const Keep &)> &solve) const {
        std::vector<double> wall;
        std::vector<double> cpu;
        double error = 0, total = 0;
        for (int run = 0; run <= runs; run++) {
            size_t sample = 0;
            State kept(exact.size(), NAN);
            const auto keep = [&](const double *v) {
                if (sample < times.size()) std::copy(v, v + n, kept.begin() + n * sample++);
            };
            const auto start = std::chrono::steady_clock::now();
            const std::clock_t used = std::clock();
            try {
                solve(keep);
            } catch (const std::exception &failure) {
                std::fprintf(stderr, "odeint %s %s: %s\n", scheme, setting.c_str(), failure.what());
                return;
            }
            const double took =
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
            error = 0;
            for (size_t i = 0; i < kept.size(); i++) {
                const double d = std::fabs(kept[i] - exact[i]);
                if (!(d <= error)) error = d;
            }
            if (run == 0) continue;
            wall.push_back(took);
            cpu.push_back(double(std::clock() - used) / CLOCKS_PER_SEC);
            if ((total += took) + took > longest) break;
        }
        if (!(error < 0.5)) {
            std::fprintf(stderr, "odeint %s %s, kappa %g: error %.1e, too large a step\n", scheme,
                         setting.c_str(), kappa, error);
            return;
        }
        std::printf("{\"program\": \"odeint\", \"scheme\": \"%s\", \"kappa\": %.17g, "
                    "\"setting\": \"%s\", \"error\": %.17g",
                    scheme, kappa, setting.c_str(), error);
        list("seconds", wall);
        list("cpu_seconds", cpu);
        std::printf("}\n");
    }

    static void list(const char *name, const std::vector<double> &values) {
        std::printf(", \"%s\": [", name);
        for (size_t i = 0; i < values.size(); i++) std::printf("%s%.9g", i ? ", " : "", values[i]);
        std::printf("]");
    }
};

static std::vector<double> read(const char *path) {
    std::vector<double> values;
    if (FILE *file = std::fopen(path, "rb")) {
        for (double value; std::fread(&value, sizeof value, 1, file) == 1;) values.push_back(value);
        std::fclose(file);
    }
    return values;
}

template <class Stepper>
static void adaptive(const Bench &bench, const Chain &chain, const char *scheme) {
    for (int exponent = 3; exponent <= 13; exponent++) {
        const double tolerance = std::pow(10, -exponent);
        char setting[32];
        std::snprintf(setting, sizeof setting, "tolerance %.0e", tolerance);
        bench.measure(scheme, setting, [&](const Bench::Keep &keep) {
            State y(2 * bench.n, 0.0);
            y[bench.n] = 1;
            odeint::integrate_times(odeint::make_controlled(tolerance, tolerance, Stepper()),
                                    FirstOrder{chain}, y, bench.times.begin(), bench.times.end(),
                                    1e-2,
                                    [&](const State &y, double) { keep(y.data() + bench.n); });
        });
    }
}

int main(int argc, char **argv) {
    if (argc != 7) return std::fputs("KAPPA SITES RUNS LONGEST_S TIMES EXACT\n", stderr), 2;
    Bench bench;
    bench.kappa = std::atof(argv[1]);
    bench.n = size_t(std::atoi(argv[2]));
    bench.runs = std::atoi(argv[3]);
    bench.longest = std::atof(argv[4]);
    bench.times = read(argv[5]);
    bench.exact = read(argv[6]);
    if (bench.n == 0 || bench.times.size() < 2 ||
        bench.exact.size() != bench.n * bench.times.size()) {
        return std::fputs("odeint: the files do not fit each other\n", stderr), 2;
    }
    Chain chain{std::vector<double>(bench.n), State(bench.n)};
    for (size_t j = 0; j < bench.n; j++) chain.coefficient[j] = j % 2 ? bench.kappa : 1;

    adaptive<odeint::runge_kutta_dopri5<State>>(bench, chain, "dopri5");
    adaptive<odeint::runge_kutta_fehlberg78<State>>(bench, chain, "fehlberg78");
    for (int steps = 16; steps <= 8192; steps *= 4) {
        const std::string setting = std::to_string(steps) + " steps a sample";
        bench.measure("SB3A", setting, [&](const Bench::Keep &keep) {
            State x(bench.n, 0.0), v(bench.n, 0.0);
            v[0] = 1;
            odeint::symplectic_rkn_sb3a_mclachlan<State> stepper;
            keep(v.data());
            for (size_t sample = 1; sample < bench.times.size(); sample++) {
                const double h = (bench.times[sample] - bench.times[sample - 1]) / steps;
                for (int step = 0; step < steps; step++) {
                    stepper.do_step(Forces{chain}, std::make_pair(std::ref(x), std::ref(v)), 0.0, h);
                }
                keep(v.data());
            }
        });
    }
}
