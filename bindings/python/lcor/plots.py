# SPDX-License-Identifier: MIT
"""Pictures of what the method does (extra ``plots``: matplotlib).

Each function returns a :class:`matplotlib.figure.Figure` of its own, so nothing here touches
pyplot, windows or a session's state; ``figure.savefig("name.png")`` writes it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

try:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.colors import ListedColormap, LogNorm
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
except ImportError as error:
    raise ImportError('lcor.plots needs matplotlib: pip install "lcor[plots]"') from error

import lcor

#: Blue for the correction, orange for the conventional method, grey for what is given.
NEW, OLD, GIVEN = "#1f5fa8", "#d9691a", "#777777"


def _figure(
    columns: int = 1, rows: int = 1, width: float = 4.2, height: float = 3.4
) -> tuple[Figure, NDArray[Any]]:
    figure = Figure(figsize=(width * columns, height * rows), dpi=150, layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False)
    for ax in axes.flat:
        ax.spines[["top", "right"]].set_visible(False)
        ax.grid(True, color="#e4e4e4", linewidth=0.6)
        ax.set_axisbelow(True)
    return figure, axes


def _picture(ax: Axes, title: str) -> None:
    ax.set_title(title, fontsize=10)
    ax.set_xticks([])
    ax.set_yticks([])
    ax.grid(False)
    ax.spines[:].set_visible(False)


def _hue_degrees(lab: NDArray[Any]) -> NDArray[Any]:
    angle: NDArray[Any] = np.degrees(np.asarray(lcor.hue(lab)))
    angle[np.asarray(lcor.chroma(lab)) < 1e-6] = np.nan  # grey has no hue
    return angle


def sweep(
    contrast: float = 23.4,
    rgb: Sequence[float] = (250 / 255, 50 / 255, 150 / 255),
    illuminance: ArrayLike | None = None,
) -> dict[str, NDArray[Any]]:
    """One colour under many illuminances, as in the paper's Table 4 and Figure 5.

    Parameters
    ----------
    contrast
        c of the device [1].
    rgb
        Linear RGB of the texture; its own reflectance Y is the patch's rho.
    illuminance : (n,)
        Relative to the mean; default 8^-1..8^1 at equal steps of the logarithm.

    Returns
    -------
    dict
        illuminance, and for each method the display luminance H in units of its middle, the hue
        [degrees], chroma and rgb: ``new_luminance`` and so on for the correction, ``old_...`` for
        eq 19.

    Examples
    --------
    >>> import lcor.plots
    >>> data = lcor.plots.sweep(illuminance=[0.5, 1.0])
    >>> data["new_luminance"].round(9)
    array([0.5, 1. ])
    """
    light = (
        8.0 ** np.linspace(-1, 1, 1201) if illuminance is None else np.asarray(illuminance, float)
    )
    colour = np.asarray(rgb, np.float64)
    lightness = float(lcor.rgb_to_lab(colour)[0])
    rho = float(lcor.lab_to_rgb([lightness, 0.0, 0.0])[0])  # Y of the grey of equal lightness
    new, _ = lcor.Plan(contrast, r_mean=rho, rho=rho).apply(colour, light)
    old = lcor.conventional(colour, light, 1.0)
    data: dict[str, NDArray[Any]] = {"illuminance": light}
    for name, pixels in (("new", new), ("old", old)):
        lab = lcor.rgb_to_lab(pixels)
        grey = lcor.lab_to_rgb(np.stack([lab[:, 0], 0 * lab[:, 0], 0 * lab[:, 0]], axis=-1))
        y = grey[:, 0]
        # eq 10: H = Jmin + Y (Jmax - Jmin), here with Jmin = 1, Jmax = c
        data[f"{name}_luminance"] = (1 + y * (contrast - 1)) / ((1 + contrast) / 2)
        data[f"{name}_hue"] = _hue_degrees(lab)
        data[f"{name}_chroma"] = np.asarray(lcor.chroma(lab))
        data[f"{name}_rgb"] = pixels
    return data


def _log_ticks(ax: Axes, low: float, high: float) -> None:
    """Powers of two as people say them: 1/4, 1/2, 1, 2."""
    ticks = [k for k in range(-20, 21) if low <= 2.0**k <= high]
    ax.set_xscale("log", base=2)
    ax.set_xticks([2.0**k for k in ticks], [f"{2**k}" if k >= 0 else f"1/{2**-k}" for k in ticks])
    ax.minorticks_off()


def figure5(
    contrast: float = 23.4, rgb: Sequence[float] = (250 / 255, 50 / 255, 150 / 255)
) -> Figure:
    """The paper's Figure 5: display luminance, hue and chroma against illuminance.

    Parameters as for :func:`sweep`.
    """
    data = sweep(contrast, rgb, 8.0 ** np.linspace(-1.4, 1, 1441))
    light = data["illuminance"]
    figure, axes = _figure(3, height=3.7)
    panels = [
        ("luminance", r"(a) display luminance $H / J_{cen}$"),
        ("hue", r"(b) hue angle $\theta$ [degrees]"),
        ("chroma", r"(c) chroma $S$"),
    ]
    for ax, (key, title) in zip(axes[0], panels):
        ax.plot(light, data[f"old_{key}"], color=OLD, linewidth=2.6, label="conventional (eq 19)")
        ax.plot(light, data[f"new_{key}"], color=NEW, label="lightness correction")
        _log_ticks(ax, light[0], light[-1])
        ax.set_xlabel("illuminance / mean illuminance")
        ax.set_title(title, fontsize=10, pad=18)
        for channel, name in zip(rgb, "RGB"):
            if light[0] < 1 / channel < light[-1]:
                ax.axvline(1 / channel, color=GIVEN, linewidth=0.7, linestyle=":")
                ax.annotate(
                    name,
                    (1 / channel, 1),
                    xycoords=("data", "axes fraction"),
                    xytext=(0, 2),
                    textcoords="offset points",
                    ha="center",
                    fontsize=8,
                    color=GIVEN,
                )
    _mark_range(axes[0, 0], contrast)
    axes[0, 1].margins(y=0.15)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    handles.append(Line2D([], [], color=GIVEN, linewidth=0.7, linestyle=":"))
    labels.append("eq 19 saturates R, G, B")
    figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=8, frameon=False)
    figure.suptitle(
        "one colour, R = {:.0f}, G = {:.0f}, B = {:.0f}, under growing illuminance; "
        "device contrast c = {:g}".format(*(255 * v for v in rgb), contrast),
        fontsize=10,
    )
    return figure


def _mark_range(ax: Axes, contrast: float) -> None:
    """The line of proportion in a panel of display luminance, with its ends J1 and J2."""
    ends = np.array(lcor.adapt_range(1.0, 1.0, contrast))
    ax.set_yscale("log", base=2)
    low, high = ax.get_ylim()
    ax.set_yticks(
        [2.0**k for k in range(-4, 2)], ["1/16", "1/8", "1/4", "1/2", "1", "2"], minor=False
    )
    ax.minorticks_off()
    ax.set_ylim(low, high)
    ax.plot(ends, ends, color=GIVEN, linewidth=0.9, linestyle="--", label="proportional")
    ax.plot(ends, ends, "o", color=NEW, markersize=4)
    for end, text, offset in zip(ends, (r"$J_1$", r"$J_2$"), ((8, -2), (6, -12))):
        ax.annotate(text, (end, end), xytext=offset, textcoords="offset points", fontsize=9)


def adaptation(contrast: float = 23.4, exponents: Sequence[float] = (0.5, 1.0, 2.0)) -> Figure:
    """The curve of eq 8 with J1 and J2 (the paper's Figure 1).

    Parameters
    ----------
    contrast
        Jmax / Jmin of the device [1].
    exponents
        Values of t, one curve each.
    """
    figure, axes = _figure(width=5.4, height=3.8)
    ax = axes[0, 0]
    j = np.logspace(-3, 2, 1201)
    for t, shade in zip(exponents, np.linspace(0.35, 1.0, len(exponents))):
        j1, j2 = lcor.adapt_range(1.0, 1.0, contrast, t)
        ax.loglog(
            j,
            lcor.adapt(j, 1.0, 1.0, contrast, t),
            color=NEW,
            alpha=shade,
            label=f"$t$ = {t:g}: $J_2 / J_1$ = {j2 / j1:.3g}",
        )
        ax.plot([j1, j2], [1, contrast], "o", color=NEW, alpha=shade, markersize=4)
        if t == 1.0:
            for x, y, text, above in ((j1, 1, "$J_1$", -13), (j2, contrast, "$J_2$", 6)):
                ax.annotate(text, (x, y), (0, above), textcoords="offset points", ha="center")
    middle = (1 + contrast) / 2
    ax.plot([j[0], 1, 1], [middle, middle, 0.7], color=GIVEN, linewidth=0.7, linestyle=":")
    for y, text in ((1, "$J_{min}$"), (middle, "$J_{cen}$"), (contrast, "$J_{max}$")):
        ax.annotate(text, (1.01, y), xycoords=("axes fraction", "data"), va="center", fontsize=9)
    ax.set_xlabel(r"scene luminance $J / \bar{J}$")
    ax.set_ylabel("display luminance $H / J_{min}$")
    ax.set_ylim(0.6, 1.8 * contrast)
    ax.legend(fontsize=8, frameon=False, loc="lower right")
    ax.set_title(f"adaptation (eq 8), c = {contrast:g}", fontsize=10)
    return figure


def _plain_log(axis: Axis, low: float, high: float) -> None:
    """Numbers as people write them on a logarithmic axis too short for powers of ten."""
    if high > 100 * low:
        return
    axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high > 8 * low else range(1, 10)))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def _plain_bar(figure: Figure, shown: Any, ax: Axes) -> Any:
    bar = figure.colorbar(shown, ax=ax, shrink=0.85)
    _plain_log(bar.ax.yaxis, shown.norm.vmin, shown.norm.vmax)
    return bar


def false_colour(illuminance: ArrayLike, unit: str = "", title: str = "illuminance") -> Figure:
    """A map of illuminance in false colour, logarithmic, with its legend.

    Parameters
    ----------
    illuminance : (H, W)
        Values >= 0.
    unit
        Written beside the legend, for example "lx".
    """
    values = np.asarray(illuminance, np.float64)
    lit = values[values > 0]
    if lit.size == 0:
        raise ValueError("no pixel is lit: nothing to show")
    figure, axes = _figure(width=5.0, height=4.0)
    ax = axes[0, 0]
    low, high = np.quantile(lit, [0.001, 0.999])
    low = min(low, high / 1.001)
    shown = ax.imshow(np.maximum(values, low), cmap="inferno", norm=LogNorm(low, high))
    _picture(ax, title)
    bar = _plain_bar(figure, shown, ax)
    bar.set_label(unit)
    return figure


def _show(ax: Axes, picture: ArrayLike, title: str) -> None:
    pixels = np.asarray(picture)
    whole = pixels / np.iinfo(pixels.dtype).max if pixels.dtype.kind == "u" else pixels
    ax.imshow(np.clip(whole, 0, 1))
    _picture(ax, title)


def hue_change(
    before: ArrayLike,
    after: ArrayLike,
    space: str = "srgb",
    transfer: str | float = "srgb",
    least_chroma: float = 2.0,
) -> NDArray[Any]:
    """How far hue (eq 17) turns from one picture to another.

    Parameters
    ----------
    before, after : (..., 3)
        Stored values, 0..1 or uint8; `space` and `transfer` say how.
    least_chroma
        Pixels below it in either picture have no hue to speak of.

    Returns
    -------
    (...)
        Degrees, -180..180; 0 where there is no hue.

    Examples
    --------
    >>> import lcor.plots
    >>> change = lcor.plots.hue_change([[0.5, 0.2, 0.3]], [[0.5, 0.4, 0.1]], transfer="linear")
    >>> change.round(1)
    array([102.1])
    """
    lab = [lcor.rgb_to_lab(p, space, transfer=transfer) for p in (before, after)]
    change = np.degrees(np.asarray(lcor.hue(lab[1])) - np.asarray(lcor.hue(lab[0])))
    change = (change + 180) % 360 - 180
    coloured = np.minimum(lcor.chroma(lab[0]), lcor.chroma(lab[1])) >= least_chroma
    return np.where(coloured, change, 0.0)


def show_hue_change(ax: Axes, change: ArrayLike, title: str = "change of hue") -> Any:
    """Draw a map of :func:`hue_change`, -10..10 degrees; returns what a colour bar needs."""
    shown = ax.imshow(np.asarray(change), cmap="RdBu_r", vmin=-10, vmax=10)
    _picture(ax, title)
    return shown


def before_after(
    before: ArrayLike,
    after: ArrayLike,
    space: str = "srgb",
    transfer: str | float = "srgb",
    titles: tuple[str, str] = ("before", "after"),
) -> Figure:
    """Two pictures side by side and the change of hue between them.

    Parameters
    ----------
    before, after : (H, W, 3)
        Stored values, 0..1 or uint8; `space` and `transfer` say how.

    Pixels of little chroma (below 2 in either) have no hue to speak of and stay white.
    """
    figure, axes = _figure(3)
    for ax, picture, title in zip(axes[0], (before, after), titles):
        _show(ax, picture, title)
    shown = show_hue_change(axes[0, 2], hue_change(before, after, space, transfer))
    figure.colorbar(shown, ax=axes[0, 2], shrink=0.7, extend="both").set_label("degrees")
    return figure


def figure3(
    texture: ArrayLike,
    illuminance: ArrayLike,
    contrast: float = 23.4,
    space: str = "srgb",
    transfer: str | float = "srgb",
) -> Figure:
    """The paper's Figure 3: texture, illuminance, eq 19, the correction, and how hue turns.

    Parameters
    ----------
    texture : (H, W, 3)
        Stored values; `space` and `transfer` say how.
    illuminance : (H, W)
        Any unit. Both methods show a texel in mean illuminance at the middle of their range.
    contrast
        c of the device [1].
    """
    light = np.asarray(illuminance, np.float64)
    mean = lcor.geometric_mean(light)
    options: dict[str, Any] = {"space": space, "transfer": transfer}
    new = lcor.correct(texture, light, contrast, **options)
    old = lcor.conventional(texture, light / mean, 1.0, **options)
    figure, axes = _figure(3, 2, height=3.0)
    _show(axes[0, 0], texture, "(a) texture")
    level = axes[1, 0].imshow(light / mean, cmap="inferno", norm=LogNorm())
    _picture(axes[1, 0], "(b) illuminance / mean")
    _plain_bar(figure, level, axes[1, 0])
    for row, picture, name in ((0, old, "(c) conventional, eq 19"), (1, new, "(d) correction")):
        _show(axes[row, 1], picture, name)
        change = hue_change(texture, picture, space, transfer)
        turn = show_hue_change(axes[row, 2], change, f"change of hue by {name[:3]}")
    figure.colorbar(turn, ax=axes[:, 2], shrink=0.6, extend="both").set_label("degrees")
    return figure


def masks(
    plan: lcor.Plan, rgb: ArrayLike, illuminance: ArrayLike, rho: ArrayLike | None = None
) -> Figure:
    """Which pixels the device cannot show as asked: too dark, too light, out of gamut.

    Parameters
    ----------
    plan, rgb, illuminance, rho
        As for :meth:`lcor.Plan.apply`, the pixels (H, W, 3).
    """
    pixels = np.asarray(rgb)
    kinds = np.zeros(pixels.shape[:2], np.uint8)
    out = {
        gamut: lcor.Plan(**{**plan.options, "gamut": gamut}).apply(
            pixels, illuminance, rho, np.empty(pixels.shape, np.float64)
        )[0]
        for gamut in ("keep-hue", "clip")
    }
    kinds[(np.abs(out["keep-hue"] - out["clip"]) > 1e-9).any(axis=-1)] = 3
    kinds[(out["keep-hue"] <= 0).all(axis=-1)] = 1
    kinds[(out["keep-hue"] >= 1 - 1e-12).all(axis=-1)] = 2
    colours = ["#e8e8e8", "#17324d", "#ffd24d", "#c23b75"]
    names = ["shown as asked", "black: $J < J_1$", "white: $J > J_2$", "chroma reduced to fit"]
    figure, axes = _figure(width=5.0, height=4.2)
    ax = axes[0, 0]
    ax.imshow(kinds, cmap=ListedColormap(colours), vmin=0, vmax=3, interpolation="nearest")
    _picture(ax, f"limits of the device, c = {plan.options['contrast']:g}")
    counts = np.bincount(kinds.ravel(), minlength=4) / kinds.size
    labels = [f"{name}: {100 * share:.2f} %" for name, share in zip(names, counts)]
    figure.legend(
        handles=[Patch(color=c, label=text) for c, text in zip(colours, labels)],
        loc="outside lower center",
        ncols=2,
        fontsize=8,
        frameon=False,
    )
    return figure


def repeatability(profile: lcor.Profile) -> Figure:
    """Readings of white and black around their medians, and the contrast they give.

    Parameters
    ----------
    profile
        With visual densities of white and black.
    """
    result = profile.evaluate()
    figure, axes = _figure(2)
    patches = [
        ("white", result["d_min"], result["u_min"], (255, 255, 255)),
        ("black", result["d_max"], result["u_max"], (0, 0, 0)),
    ]
    for ax, (name, median, u, rgb) in zip(axes[0], patches):
        readings = [r for r in profile.readings if r.visual is not None and r.rgb == rgb]
        number = np.arange(1, len(readings) + 1)
        values = np.array([r.visual for r in readings])
        used = np.array([not r.rejected for r in readings], bool)
        ax.axhspan(median - 1.96 * u, median + 1.96 * u, color=NEW, alpha=0.15, linewidth=0)
        ax.axhline(median, color=NEW, linewidth=1)
        ax.plot(number[used], values[used], "o", color=NEW, markersize=5)
        ax.plot(number[~used], values[~used], "x", color=OLD, label="rejected")
        if not used.all():
            ax.legend(fontsize=7, frameon=False)
        ax.set_title(f"{name}: median {median:.3f}, u = {u:.4f}", fontsize=10)
        ax.set_xlabel("number of the reading")
        ax.set_ylabel("visual density [1]")
        ax.set_xticks(number)
    figure.suptitle(
        f"c = {result['contrast']:.2f} ± {result['contrast_u95']:.2f} (95 %)", fontsize=11
    )
    return figure


def convergence(
    scene: lcor.Scene, tolerances: Sequence[float] = (0.1, 0.03, 0.01, 0.003, 0.001)
) -> Figure:
    """How the solver's estimated error, time and memory follow the tolerance asked for.

    Parameters
    ----------
    scene
        Solved once for each tolerance.
    """
    reports = [lcor.solve_radiosity(scene, t).report for t in tolerances]
    figure, axes = _figure(2)
    left, right = axes[0]
    left.loglog(tolerances, [r["error_rms"] for r in reports], "o-", color=NEW, label="rms")
    left.loglog(
        tolerances, [r["error_max"] for r in reports], "s--", color=OLD, label="largest seen"
    )
    left.loglog(
        tolerances, tolerances, color=GIVEN, linewidth=0.8, linestyle=":", label="asked for"
    )
    left.set_xlabel("tolerance asked for, rms")
    left.set_ylabel("estimated relative error")
    left.legend(fontsize=8, frameon=False)
    seconds = [max(r["seconds"], 1e-7) for r in reports]
    right.loglog(seconds, [r["error_rms"] for r in reports], "o-", color=NEW)
    for r, s in zip(reports, seconds):
        right.annotate(
            f"{r['bytes'] / 1e6:.2g} MB",
            (s, r["error_rms"]),
            fontsize=6,
            xytext=(4, 3),
            textcoords="offset points",
        )
    right.margins(x=0.18)
    right.set_xlabel("seconds, one thread")
    right.set_ylabel("estimated relative error, rms")
    left.set_title("error", fontsize=10)
    right.set_title("what it costs in time and memory", fontsize=10)
    return figure


def fronts(
    points: Mapping[str, Sequence[tuple[float, float]]],
    cost: str,
    error: str,
    title: str = "",
) -> Figure:
    """Speed against accuracy: one line of (cost, error) points for each way of doing it.

    Parameters
    ----------
    points
        Name -> list of (cost, error), both above 0; better is down and left.
    cost, error, title
        What the axes are.
    """
    figure, axes = _figure(width=7.0, height=4.0)
    ax = axes[0, 0]
    for index, (name, pairs) in enumerate(points.items()):
        ordered = sorted(pairs)
        marker = "os^Dv<>P*X"[index % 10]
        own = name.startswith("lcor")
        ax.loglog(
            [p[0] for p in ordered],
            [max(p[1], 1e-17) for p in ordered],
            marker + "-",
            color=NEW if own else None,
            linewidth=1.6 if own else 0.9,
            markersize=5,
            label=name,
        )
    ax.set_xlabel(cost)
    ax.set_ylabel(error)
    for axis in (ax.xaxis, ax.yaxis):
        _plain_log(axis, *axis.get_view_interval())
    ax.set_title(title, fontsize=10)
    figure.legend(loc="outside right upper", fontsize=8, frameon=False)
    return figure


def chroma_rule(steps: int = 400) -> Figure:
    """k of eq 16 against the new lightness, for several old ones (the paper's Figure 2)."""
    figure, axes = _figure(width=5.0)
    ax = axes[0, 0]
    new = np.linspace(0, 100, steps)
    for old in (20.0, 40.0, 60.0, 80.0):
        k = np.where(new <= old, new / old, (100 - new) / (100 - old))
        ax.plot(new, k, color=NEW, alpha=0.35 + 0.65 * old / 80)
        ax.annotate(f"$L^*$ = {old:g}", (old, 1.02), ha="center", fontsize=8)
    ax.set_ylim(0, 1.1)
    ax.set_xlabel("new lightness $L^*_{new}$")
    ax.set_ylabel("$k$ = new chroma / old chroma")
    ax.set_title("chroma follows lightness (eq 16)", fontsize=10)
    return figure
