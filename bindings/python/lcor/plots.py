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
    from matplotlib.colors import ListedColormap, LogNorm
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch
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


def figure5(
    contrast: float = 23.4, rgb: Sequence[float] = (250 / 255, 50 / 255, 150 / 255)
) -> Figure:
    """The paper's Figure 5: display luminance, hue and chroma against illuminance.

    Parameters as for :func:`sweep`.
    """
    data = sweep(contrast, rgb)
    light = data["illuminance"]
    figure, axes = _figure(3)
    panels = [
        ("luminance", "(a) display luminance H / Jcen", "log"),
        ("hue", "(b) hue angle [degrees]", "linear"),
        ("chroma", "(c) chroma", "linear"),
    ]
    for ax, (key, title, scale) in zip(axes[0], panels):
        ax.plot(light, data[f"old_{key}"], color=OLD, label="conventional (eq 19)")
        ax.plot(light, data[f"new_{key}"], color=NEW, label="lightness correction")
        ax.set_xscale("log", base=8)
        ax.set_yscale(scale)
        ax.set_xlabel("illuminance / mean")
        ax.set_title(title, fontsize=10)
        for channel, name in zip(rgb, "RGB"):
            if light[0] < 1 / channel < light[-1]:
                ax.axvline(1 / channel, color=GIVEN, linewidth=0.7, linestyle=":")
                ax.annotate(
                    f"{name}=255",
                    (1 / channel, 1),
                    xycoords=("data", "axes fraction"),
                    rotation=90,
                    va="top",
                    ha="right",
                    fontsize=6,
                    color=GIVEN,
                )
    low, high = lcor.adapt_range(1.0, 1.0, contrast)
    ends = np.array([low, high])
    axes[0, 0].plot(ends, ends, color=GIVEN, linewidth=0.8, linestyle="--", label="proportional")
    axes[0, 0].legend(fontsize=7, frameon=False)
    figure.suptitle(
        "R = {:.0f}, G = {:.0f}, B = {:.0f}, c = {:g}".format(*(255 * v for v in rgb), contrast),
        fontsize=10,
    )
    return figure


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
    j = np.logspace(-3, 3, 1201)
    for t, shade in zip(exponents, np.linspace(0.35, 1.0, len(exponents))):
        j1, j2 = lcor.adapt_range(1.0, 1.0, contrast, t)
        ax.loglog(
            j, lcor.adapt(j, 1.0, 1.0, contrast, t), color=NEW, alpha=shade, label=f"t = {t:g}"
        )
        ax.plot([j1, j2], [1, contrast], "o", color=NEW, alpha=shade, markersize=4)
        if t == 1.0:
            ax.annotate("J1", (j1, 1), textcoords="offset points", xytext=(0, -12), ha="center")
            ax.annotate(
                "J2", (j2, contrast), textcoords="offset points", xytext=(0, 6), ha="center"
            )
    middle = (1 + contrast) / 2
    ax.plot([j[0], 1, 1], [middle, middle, 0.7], color=GIVEN, linewidth=0.7, linestyle=":")
    ax.set_xlabel("scene luminance J / mean")
    ax.set_ylabel("display luminance H / Jmin")
    ax.set_ylim(0.7, 1.6 * contrast)
    ax.legend(fontsize=8, frameon=False)
    ax.set_title(f"adaptation (eq 8), c = {contrast:g}", fontsize=10)
    return figure


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
    bar = figure.colorbar(shown, ax=ax, shrink=0.85)
    bar.set_label(unit)
    return figure


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
    first, second = np.asarray(before), np.asarray(after)
    lab = [lcor.rgb_to_lab(p, space, transfer=transfer) for p in (first, second)]
    change = np.degrees(np.asarray(lcor.hue(lab[1])) - np.asarray(lcor.hue(lab[0])))
    change = (change + 180) % 360 - 180
    coloured = np.minimum(lcor.chroma(lab[0]), lcor.chroma(lab[1])) >= 2
    figure, axes = _figure(3)
    for ax, picture, title in zip(axes[0], (first, second), titles):
        whole = picture / np.iinfo(picture.dtype).max if picture.dtype.kind == "u" else picture
        ax.imshow(np.clip(whole, 0, 1))
        _picture(ax, title)
    limit = 10.0
    shown = axes[0, 2].imshow(
        np.where(coloured, change, 0.0), cmap="RdBu_r", vmin=-limit, vmax=limit
    )
    _picture(axes[0, 2], "change of hue")
    figure.colorbar(shown, ax=axes[0, 2], shrink=0.7, extend="both").set_label("degrees")
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
    names = ["shown as asked", "black: J < J1", "white: J > J2", "chroma reduced to fit"]
    figure, axes = _figure(width=5.0, height=4.2)
    ax = axes[0, 0]
    ax.imshow(kinds, cmap=ListedColormap(colours), vmin=0, vmax=3, interpolation="nearest")
    _picture(ax, f"limits of the device, c = {plan.options['contrast']:g}")
    counts = np.bincount(kinds.ravel(), minlength=4) / kinds.size
    labels = [f"{name}: {100 * share:.2f} %" for name, share in zip(names, counts)]
    ax.legend(
        handles=[Patch(color=c, label=text) for c, text in zip(colours, labels)],
        loc="upper center",
        bbox_to_anchor=(0.5, -0.02),
        ncols=2,
        fontsize=7,
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
        ax.set_xlabel("reading")
        ax.set_ylabel("visual density")
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
    left.set_xlabel("tolerance asked for")
    left.set_ylabel("estimated error")
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
    right.set_xlabel("seconds")
    right.set_ylabel("estimated error (rms)")
    left.set_title("error", fontsize=10)
    right.set_title("what it costs", fontsize=10)
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
    figure, axes = _figure(width=6.0, height=4.2)
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
    ax.set_title(title, fontsize=10)
    ax.legend(fontsize=7, frameon=False)
    return figure


def chroma_rule(steps: int = 400) -> Figure:
    """k of eq 16 against the new lightness, for several old ones (the paper's Figure 2)."""
    figure, axes = _figure(width=5.0)
    ax = axes[0, 0]
    new = np.linspace(0, 100, steps)
    for old in (20.0, 40.0, 60.0, 80.0):
        k = np.where(new <= old, new / old, (100 - new) / (100 - old))
        ax.plot(new, k, color=NEW, alpha=0.35 + 0.65 * old / 80, label=f"L* = {old:g}")
    ax.set_xlabel("L*new")
    ax.set_ylabel("k = chroma / old chroma")
    ax.legend(fontsize=8, frameon=False)
    ax.set_title("chroma follows lightness (eq 16)", fontsize=10)
    return figure
