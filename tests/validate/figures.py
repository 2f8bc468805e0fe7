"""Pictures of the document, as SVG."""

import io

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
import numpy as np

plt.rcParams.update(
    {
        "svg.fonttype": "none",
        "font.family": "sans-serif",
        "font.sans-serif": ["DejaVu Sans"],
        "font.size": 9,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.titlesize": 10,
        "axes.titlelocation": "left",
        "legend.frameon": False,
        "figure.constrained_layout.use": True,
    }
)
BLUE, RED, GREEN, GREY, ORANGE = "#2a5d9c", "#b3261e", "#12703c", "#8a8a8a", "#c77700"


def drawn(figure):
    out = io.StringIO()
    figure.savefig(out, format="svg")
    plt.close(figure)
    text = out.getvalue()
    return text[text.index("<svg") :]


def differences(families):
    """Every difference over the allowed one, by family."""
    figure, axes = plt.subplots(figsize=(5.6, 3.2))
    names = []
    for family in families:
        shares = [row.share for part in family["parts"] for row in part.rows if row.share is not None]
        shares = [max(share, 1e-4) if np.isfinite(share) else 100.0 for share in shares]
        if not shares:
            continue
        height = len(names) + np.linspace(-0.28, 0.28, len(shares))
        axes.scatter(shares, height, s=14, color=[BLUE if share <= 1 else RED for share in shares])
        names.append(family["title"])
    axes.axvline(1, color=RED, lw=1)
    axes.set_xscale("log")
    axes.set_yticks(range(len(names)), names)
    axes.invert_yaxis()
    axes.set_xlabel("difference over that allowed (left end: below 1e-4)")
    return drawn(figure)


def coverages(intervals):
    """How often intervals hold, with the band in which that may be by chance; wide."""
    figure, axes = plt.subplots(figsize=(11.4, 0.19 * len(intervals) + 0.7))
    for row, (_, held, count, least, most) in enumerate(intervals):
        axes.plot([least / count, most / count], [row, row], color="#c9d6e6", lw=6, solid_capstyle="butt")
        axes.plot(held / count, row, "o", ms=4, color=BLUE if least <= held <= most else RED)
    names = [f"{name.removeprefix('95 % intervals of ')} ({count})" for name, _, count, *_ in intervals]
    axes.set_yticks(range(len(names)), names, fontsize=7.5)
    axes.invert_yaxis()
    axes.set_xlabel("share that holds the truth, of so many; bars: what is stated, with chance")
    return drawn(figure)


def verdicts(table):
    """What was said of fields with known answers."""
    figure, axes = plt.subplots(figsize=(5.6, 0.25 * len(table) + 0.8))
    rows = np.arange(len(table))
    right, untold, false = (np.array([row[i] for row in table]) for i in (1, 2, 3))
    axes.barh(rows, right, color=GREEN, label="right")
    axes.barh(rows, untold, left=right, color="#cfcfcf", label="cannot be told, with a reason")
    axes.barh(rows, false, left=right + untold, color=RED, label="false")
    axes.set_yticks(rows, [row[0] for row in table])
    axes.invert_yaxis()
    axes.set_xlabel("statements")
    figure.legend(loc="outside lower center", ncols=3, fontsize=8)
    return drawn(figure)


def chains(curves):
    """Processor time against error."""
    figure, panels = plt.subplots(1, len(curves), figsize=(5.6, 3.0), sharey=True, squeeze=False)
    for axes, (ratio, points) in zip(panels[0], curves.items(), strict=True):
        for (name, values), color in zip(points.items(), (BLUE, ORANGE, GREY), strict=False):
            error, seconds = np.array(sorted(values)).T
            axes.loglog(error, 1e3 * seconds, "o-", color=color, ms=4, label=name)
        axes.set_title(f"ratio {float(ratio):g}")
        axes.set_xlabel("largest error of a velocity")
    panels[0][0].set_ylabel("processor time (ms)")
    panels[0][0].legend(fontsize=7.5)
    return drawn(figure)


def transforms(table):
    """The program and SciPy."""
    figure, panels = plt.subplots(1, 2, figsize=(5.6, 2.6))
    rows = np.arange(len(table))
    titles = "whole command (processor time)", "stage along time (clock)"
    for axes, title, (mine, other) in zip(panels, titles, ((1, 2), (3, 4)), strict=True):
        axes.barh(rows - 0.18, [1e3 * row[mine] for row in table], 0.34, color=BLUE, label="cascade")
        axes.barh(
            rows + 0.18,
            [1e3 * row[other] for row in table],
            0.34,
            color=ORANGE,
            label="SciPy (pocketfft)",
        )
        axes.set_yticks(rows, [row[0] for row in table] if axes is panels[0] else [""] * len(table))
        axes.invert_yaxis()
        axes.set_title(title, fontsize=9)
        axes.set_xlabel("ms, one thread")
    handles = panels[0].get_legend_handles_labels()
    figure.legend(*handles, loc="outside lower center", ncols=2, fontsize=8)
    return drawn(figure)


def transmitted(points, least):
    """Force against angle, with what the paper says of it."""
    figure, axes = plt.subplots(figsize=(5.6, 2.8))
    angle, force = np.array(points).T
    axes.plot(angle, force, "o-", color=BLUE, ms=3.5, label="computed")
    axes.plot(
        *least, "o", color=RED, ms=6, label=f"first minimum, {least[0]:.1f}°, {1 - least[1]:.0%} lost"
    )
    axes.axhspan(0, 0.6, color="#f3e6d0", lw=0, label="published: more than 40 % lost at about 18°")
    axes.axvline(18, color=GREY, lw=0.8, ls="--")
    axes.axvline(8, color=GREY, lw=0.8, ls="--")
    axes.set_ylim(0.3, 1.05)
    axes.set_xlabel("first angle (degrees); dashed: 8° and 18° of the paper")
    axes.set_ylabel("force over that at 90°")
    axes.legend(fontsize=7.5, loc="lower right")
    return drawn(figure)


def tolerances(points):
    """Errors of chains against the requested tolerance."""
    figure, axes = plt.subplots(figsize=(5.6, 2.9))
    ratios = sorted({point[0] for point in points})
    for ratio, color in zip(ratios, plt.cm.viridis(np.linspace(0, 0.85, len(ratios))), strict=True):
        asked, found = np.array([(p[1], p[2]) for p in points if p[0] == ratio]).T
        axes.loglog(asked, found, "o-", ms=3.5, lw=1, color=color, label=f"{ratio:.4g}")
    both = np.array([1e-11, 1e-4])
    axes.loglog(both, both, color=RED, lw=1)
    axes.set_xlabel("tolerance (red: as large an error)")
    axes.set_ylabel("true error")
    axes.legend(title="stiffness ratio", fontsize=7.5, title_fontsize=7.5, ncols=2)
    return drawn(figure)


def all_of(families):
    """Each figure with its caption, of what was measured."""
    series = {}
    for family in families:
        for part in family["parts"]:
            for name, value in part.series.items():
                if name in ("coverage", "verdicts", "random_scenes"):
                    series.setdefault(name, []).extend(value)
                else:
                    series[name] = value
    found = []
    if any(row.share is not None for family in families for part in family["parts"] for row in part.rows):
        caption = "Every difference, over the one that the docs allow. Left of the line a claim holds."
        found.append((differences(families), caption))
    if "verdicts" in series:
        right, untold, false = (sum(row[i] for row in series["verdicts"]) for i in (1, 2, 3))
        caption = (
            "Statements on frequencies, wavenumbers and direction of random fields "
            "whose answer follows from how they are made: "
            f"{right} right, {untold} withheld, {false} false."
        )
        found.append((verdicts(series["verdicts"]), caption))
    if "tolerances" in series:
        caption = "Velocities of struck dimers against double-double arithmetic."
        found.append((tolerances(series["tolerances"]), caption))
    if "chains" in series:
        caption = "Struck chains of 300 sites to time 295; the program with its start and its files."
        found.append((chains(series["chains"]), caption))
    if "transforms" in series:
        found.append((transforms(series["transforms"]), "Medians of interleaved rounds."))
    if "transmitted" in series:
        caption = "The paper's experiment: force on the sensor behind 40 cylinders."
        found.append((transmitted(*series["transmitted"]), caption))
    pictures = [{"svg": svg, "caption": caption, "is_wide": False} for svg, caption in found]
    if "coverage" in series:
        caption = (
            "How often stated intervals hold what was put in, and levels of chance are exceeded by noise."
        )
        pictures.append({"svg": coverages(series["coverage"]), "caption": caption, "is_wide": True})
    return pictures
