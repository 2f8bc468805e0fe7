// Impacted Hertz chains in double-double arithmetic, by Stoermer extrapolation.
//
//   m_j x_j'' = F_{j-1} - F_j,   F_j = c_j max(x_j - x_{j+1}, 0)^{3/2},
//
// all sites touching at t = 0, the last contact with a fixed wall (c = 0: with nothing).
// Stoermer's rule (leapfrog) with 1, 2, ..., COLUMNS substeps has an error in even powers of the
// substep, which Aitken and Neville's scheme takes to 0; no table of coefficients is needed. The
// difference of the last two columns controls the step. Where a contact opens or closes the force
// has an infinite second derivative: steps shrink towards it until its share is below the
// tolerance, and grow again behind it.
//
// Source: P. Deuflhard, SIAM Rev. 27 (1985) 505; T. J. Dekker, Numer. Math. 18 (1971) 224 (the
// arithmetic).
// Compiled and run by chain_reference.py:
//   chain_reference TOLERANCE TIMES OUT < CHAIN
// CHAIN: a line a site: mass, coefficient of the contact after it, initial velocity.
// TIMES: float64, ascending, the first one 0. OUT: float64, velocities (time, site), then
// displacements.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

struct dd {
    double hi, lo;
};

static inline dd quick(double a, double b) {
    const double s = a + b;
    return {s, b - (s - a)};
}

static inline dd operator+(dd a, dd b) {
    const double s = a.hi + b.hi, t = s - a.hi;
    const double es = (a.hi - (s - t)) + (b.hi - t);
    const double r = a.lo + b.lo, u = r - a.lo;
    const double er = (a.lo - (r - u)) + (b.lo - u);
    const dd w = quick(s, es + r);
    return quick(w.hi, w.lo + er);
}

static inline dd operator-(dd a) { return {-a.hi, -a.lo}; }
static inline dd operator-(dd a, dd b) { return a + -b; }

static inline dd operator*(dd a, dd b) {
    const double p = a.hi * b.hi;
    const double e = std::fma(a.hi, b.hi, -p);
    return quick(p, e + (a.hi * b.lo + a.lo * b.hi));
}

static inline dd operator*(dd a, double b) {
    const double p = a.hi * b;
    return quick(p, std::fma(a.hi, b, -p) + a.lo * b);
}

static inline dd divide(double a, double b) {
    const double q = a / b;
    return quick(q, std::fma(-q, b, a) / b);
}

// max(d, 0)^{3/2}
static inline dd power_3_2(dd d) {
    if (d.hi <= 0) return {0, 0};
    if (d.hi < 1e-280) return {d.hi * std::sqrt(d.hi), 0};
    const double r = 1 / std::sqrt(d.hi);
    const double s = d.hi * r;
    const double p = s * s;
    const dd rest = d - dd{p, std::fma(s, s, -p)};
    return d * quick(s, rest.hi * (0.5 * r));
}

static const int COLUMNS = 11;

struct Chain {
    std::vector<dd> inverse_mass, x, v, a;
    std::vector<double> coefficient;
    // Beyond this site all is exactly zero, since nothing has arrived.
    int reach = 0;

    int n() const { return int(coefficient.size()); }

    // Accelerations of the first m sites at y.
    void accelerate(const std::vector<dd> &y, std::vector<dd> &out, int m) const {
        dd before{0, 0};
        for (int j = 0; j < m; j++) {
            const dd right = j + 1 < n() ? y[j + 1] : dd{0, 0};
            const dd force = power_3_2(y[j] - right) * coefficient[j];
            out[j] = (before - force) * inverse_mass[j];
            before = force;
        }
    }
};

int main(int argc, char **argv) {
    if (argc != 4) return std::fputs("TOLERANCE TIMES OUT < CHAIN\n", stderr), 2;
    const double tolerance = std::atof(argv[1]);
    std::vector<double> times;
    if (FILE *file = std::fopen(argv[2], "rb")) {
        for (double t; std::fread(&t, sizeof t, 1, file) == 1;) times.push_back(t);
        std::fclose(file);
    }
    const dd zero{0, 0};
    Chain c;
    for (double mass, coefficient, velocity;
         std::scanf("%lf %lf %lf", &mass, &coefficient, &velocity) == 3;) {
        const dd guess = divide(1, mass);
        c.inverse_mass.push_back(guess * (dd{2, 0} - guess * mass));
        c.coefficient.push_back(coefficient);
        c.x.push_back(zero);
        c.v.push_back({velocity, 0});
        if (velocity != 0) c.reach = c.n();
    }
    const int n = c.n();
    if (n < 1 || !(tolerance > 0) || times.empty() || times[0] != 0) {
        return std::fputs("chain_reference: an argument makes no sense\n", stderr), 2;
    }
    c.a.assign(n, zero);

    // Weights of Aitken and Neville's scheme: 1 / ((n_i / n_{i-k})^2 - 1).
    dd weight[COLUMNS][COLUMNS];
    for (int i = 0; i < COLUMNS; i++) {
        for (int k = 1; k <= i; k++) {
            const double a = (i + 1) * (i + 1), b = (i + 1 - k) * (i + 1 - k);
            weight[i][k] = divide(b, a - b);
        }
    }

    // One row of the scheme a place: increments of x and of v.
    std::vector<dd> table[2][COLUMNS], y(n), d(n), f(n);
    for (auto &part : table)
        for (auto &row : part) row.assign(n, zero);
    std::vector<double> out_v, out_x;
    const auto keep = [&] {
        for (int j = 0; j < n; j++) out_v.push_back(c.v[j].hi), out_x.push_back(c.x[j].hi);
    };
    keep();
    double h = 1e-3;
    dd now = zero;
    long steps = 0, rejected = 0;
    for (size_t sample = 1; sample < times.size(); sample++) {
        while (true) {
            const dd rest = dd{times[sample], 0} - now;
            if (rest.hi <= 0) break;
            const bool last = h >= rest.hi;
            const dd step = last ? rest : dd{h, 0};
            // The front gains at most one site an evaluation.
            const int m = std::min(n, c.reach + COLUMNS + 2);
            c.accelerate(c.x, c.a, m);
            for (int i = 0; i < COLUMNS; i++) {
                const int parts = i + 1;
                const dd small = step * divide(1, parts);
                const dd half = small * 0.5, square = small * small;
                for (int j = 0; j < m; j++) {
                    d[j] = (c.v[j] + c.a[j] * half) * small;
                    y[j] = c.x[j] + d[j];
                }
                for (int k = 1; k < parts; k++) {
                    c.accelerate(y, f, m);
                    for (int j = 0; j < m; j++) {
                        d[j] = d[j] + f[j] * square;
                        y[j] = y[j] + d[j];
                    }
                }
                c.accelerate(y, f, m);
                const dd per = dd{double(parts), 0} * divide(1, step.hi);
                // 1 / small to double-double: one Newton step.
                const dd inverse = per * (dd{2, 0} - per * small);
                for (int j = 0; j < m; j++) {
                    table[0][i][j] = y[j] - c.x[j];
                    table[1][i][j] = d[j] * inverse + f[j] * half - c.v[j];
                }
            }
            double error = 0;
            for (auto &part : table) {
                for (int j = 0; j < m; j++) {
                    // In place: after i rounds part[i] holds the i-th diagonal entry.
                    dd before = zero;
                    for (int k = 1; k < COLUMNS; k++) {
                        if (k == COLUMNS - 1) before = part[COLUMNS - 1][j];
                        for (int i = COLUMNS - 1; i >= k; i--) {
                            const dd difference = part[i][j] - part[i - 1][j];
                            part[i][j] = part[i][j] + difference * weight[i][k];
                        }
                    }
                    const dd change = part[COLUMNS - 1][j] - before;
                    error = std::max(error, std::fabs(change.hi));
                }
            }
            const double factor = 0.9 * std::pow(tolerance / (error + 1e-40), 1.0 / (2 * COLUMNS - 1));
            if (error > tolerance) {
                rejected++;
                h = step.hi * std::clamp(factor, 0.1, 0.8);
                if (h < 1e-25) return std::fputs("chain_reference: the step vanishes\n", stderr), 1;
                continue;
            }
            steps++;
            for (int j = 0; j < m; j++) {
                c.x[j] = c.x[j] + table[0][COLUMNS - 1][j];
                c.v[j] = c.v[j] + table[1][COLUMNS - 1][j];
                if (c.v[j].hi != 0 || c.x[j].hi != 0) c.reach = std::max(c.reach, j + 1);
            }
            now = last ? dd{times[sample], 0} : now + step;
            const double next = step.hi * std::clamp(factor, 0.1, 4.0);
            h = last ? std::max(h, next) : next;
        }
        keep();
    }
    std::fprintf(stderr, "%d sites, tolerance %g: %ld steps, %ld rejected\n", n, tolerance, steps,
                 rejected);
    FILE *file = std::fopen(argv[3], "wb");
    if (!file) return std::perror(argv[3]), 1;
    const bool whole = std::fwrite(out_v.data(), 8, out_v.size(), file) == out_v.size() &&
                       std::fwrite(out_x.data(), 8, out_x.size(), file) == out_x.size();
    return std::fclose(file) == 0 && whole ? 0 : 1;
}
