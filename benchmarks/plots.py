"""Draws the texts' own figures from `addon.maths` into docs/img/theory_*.png: `python -m benchmarks.plots`. Needs matplotlib.

T4 figures 19, 20, 22, 23, 26 and LogPSM figures 5.4, 5.6, 5.20, with the texts' parameters. Shown in docs/theory.md.
"""

from __future__ import annotations

from math import cos, degrees, inf, log1p, pi, radians, sin, sqrt, tan
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from addon.maths.choices import WARPS, PartitionChoice, WarpChoice
from addon.maths.error.aliasing import (
    error_x,
    error_z,
    max_beam_error_z,
    max_error_x,
    max_error_z,
    storage_factor_log,
    storage_factor_z,
)
from addon.maths.error.warped_map import WarpedMap, partition_maps
from addon.maths.shadow.partitions import split_distances
from addon.maths.warping.formulas import gamma_lim_rad, lispsm_general_parameter, lispsm_parameter, parameter_from_eta
from tests.maths.logpsm_forms import base_error_log_t, base_error_s, base_error_t

OUT = Path(__file__).resolve().parents[1] / "docs" / "img"
NEAR, FAR = 1.0, 100.0
OVERHEAD = pi / 2


def save(figure: plt.Figure, name: str) -> None:
    """Write one picture and say so."""
    OUT.mkdir(parents=True, exist_ok=True)
    path = OUT / f"theory_{name}.png"
    figure.tight_layout()
    figure.savefig(path, dpi=110, metadata={"Software": None})
    plt.close(figure)
    print(path)


def named(axis: plt.Axes, title: str, x: str, y: str, legend: str = "best") -> plt.Axes:
    """Title, labels, legend and a light grid."""
    axis.set(title=title, xlabel=x, ylabel=y)
    axis.grid(alpha=0.25)
    axis.legend(fontsize=8, loc=legend)
    return axis


def error_along_the_view() -> None:
    """T4 figure 19: m_x(z), m_z(z) of PSM, LiSPSM and the uniform map, each divided by the least M."""
    z = np.linspace(NEAR, FAR, 1000)
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6))
    least = max_error_z(WarpedMap(NEAR, FAR, radians(45), OVERHEAD, lispsm_parameter(NEAR, FAR)))
    for label, parameter in (("PSM, n' = n", NEAR), ("LiSPSM, n' = n + √(fn)", lispsm_parameter(NEAR, FAR)), ("uniform, n' → ∞", inf)):
        m = WarpedMap(NEAR, FAR, radians(45), OVERHEAD, parameter)
        axes[0].plot(z, error_x(m, z), label=label)
        axes[1].plot(z, error_z(m, z) / least, label=label)
    for axis, top, name in ((axes[0], 20.0, "m_x"), (axes[1], 12.0, "m_z / least M_z")):
        axis.set_ylim(0.0, top)
        named(axis, f"{name} along the view (T4 fig. 19)", "z", name)
    save(figure, "19_error_along_view")


def maxima_over_eta() -> None:
    """T4 figure 20: M_x, M_z and S over η, each divided by its least."""
    eta = np.linspace(-1.0, 1.0, 401)
    maps = [WarpedMap(NEAR, FAR, radians(45), OVERHEAD, parameter_from_eta(float(e), NEAR, FAR)) for e in eta]
    m_x, m_z = (np.array([f(m) for m in maps]) for f in (max_error_x, max_error_z))
    figure, axis = plt.subplots(figsize=(6, 3.8))
    for label, values in (("M_x", m_x), ("M_z", m_z), ("S = M_x M_z", m_x * m_z)):
        axis.semilogy(eta, values / values.min(), label=label)
    axis.set_xticks([-1, 0, 1], ["−1 uniform", "0 LiSPSM", "1 PSM"])
    named(axis, "Largest errors and storage factor (T4 fig. 20)", "η", "value / least")
    save(figure, "20_maxima_over_eta")


def generalised_parameter() -> None:
    """T4 figure 22: n' over γ, (a) equal errors at both ends (39), (b) as used (42) with both convergence functions."""
    phi, limit = radians(30), gamma_lim_rad(NEAR, FAR, radians(30))
    gamma = np.linspace(0.0, OVERHEAD, 721)
    a, b, root = NEAR * tan(phi), FAR * tan(phi), sqrt(NEAR * FAR)
    equal = [(NEAR + root) * sin(g) - a * cos(g) if g >= phi else (FAR + root) * sin(g) - b * cos(g) for g in gamma]
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6))
    axes[0].plot(np.degrees(gamma), equal, label="equal m_z at near and far (39)")
    axes[0].axhline(0.0, color="k", lw=0.6)
    for kind, number in (("quadratic", 44), ("sine", 43)):
        used = [lispsm_general_parameter(NEAR, FAR, phi, float(g), kind) for g in gamma]
        axes[1].plot(np.degrees(gamma), used, label=f"(42) with r of ({number})")
    axes[1].axvline(degrees(limit), color="k", lw=0.6, ls=":", label="γ_lim (40)")
    axes[1].set_ylim(0.0, 30.0)
    for axis, part in zip(axes, "ab", strict=True):
        named(axis, f"n' of the generalised LiSPSM (T4 fig. 22{part})", "γ in degrees", "n'")
    save(figure, "22_generalised_parameter")


def error_over_gamma() -> None:
    """T4 figure 23: m_z(z) of the generalised LiSPSM for light directions from γ_lim to 90°."""
    phi, z = radians(30), np.linspace(NEAR, FAR, 800)
    figure, axis = plt.subplots(figsize=(6, 3.8))
    for gamma in np.linspace(gamma_lim_rad(NEAR, FAR, phi), OVERHEAD, 5).tolist():
        m = WarpedMap(NEAR, FAR, phi, gamma, lispsm_general_parameter(NEAR, FAR, phi, gamma))
        (line,) = axis.plot(z, error_z(m, z), label=f"γ = {degrees(gamma):.1f}°")
        axis.plot(z, error_z(m, z) * sin(gamma), color=line.get_color(), ls=":", lw=1.0)
    axis.plot([], [], color="k", ls=":", label="· sin γ: as seen in the image")
    named(axis, "m_z of the generalised LiSPSM (T4 fig. 23)", "z", "m_z (37)", "upper center")
    save(figure, "23_error_over_gamma")


def storage_over_ratio() -> None:
    """T4 figure 26: S of z partitions over f/n, light ⟂ view, with the logarithmic bound."""
    ratio, phi = np.geomspace(1.5, 1e4, 200), radians(30)
    figure, axis = plt.subplots(figsize=(6, 4.2))
    for count, color in ((1, "C3"), (2, "C1"), (4, "C2"), (8, "C0")):
        for warped, style in ((False, "--"), (True, "-")):
            values = [storage_factor_z(1.0, r, phi, count, warped) for r in ratio.tolist()]
            axis.loglog(ratio, values, color=color, ls=style, label=f"k = {count}, {'LiSPSM' if warped else 'uniform'}")
    axis.loglog(ratio, [storage_factor_log(1.0, r, phi) for r in ratio.tolist()], "k", label="logarithmic (52)")
    axis.set_ylim(0.3, 1e6)
    named(axis, "Storage factor of z partitions, φ = 30° (T4 fig. 26)", "f/n", "S")
    save(figure, "26_storage_of_partitions")


def base_errors() -> None:
    """LogPSM figure 5.4: the base error distributions over v for warps from the eye's apex to uniform (f/n = 16)."""
    v, n_bar0 = np.linspace(0.0, 1.0, 400), 1.0 / 15.0
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6))
    for eta in (1.0, 0.5, 0.0, -0.5, -1.0):
        n_bar = parameter_from_eta(eta, 1.0, 16.0) / 15.0
        axes[0].plot(v, base_error_s(v, n_bar, n_bar0), label=f"η = {eta:g}")
        axes[1].plot(v, base_error_t(v, n_bar, n_bar0), label=f"η = {eta:g}")
    axes[1].plot(v, base_error_log_t(v, n_bar0, n_bar0), "k--", label="logarithmic, n' = n")
    for axis, name in zip(axes, ("M̃_s (5.27)", "M̃_t (5.28)"), strict=True):
        named(axis, f"{name}, f/n = 16 (LogPSM fig. 5.4)", "v", name, "upper center")
    save(figure, "5_4_base_errors")


def error_over_warps() -> None:
    """LogPSM figure 5.6: errors at the near and far end, the least in between, and S, over η (f/n = 16)."""
    eta, n_bar0 = np.linspace(-0.995, 1.0, 400), 1.0 / 15.0
    n_bar = [parameter_from_eta(float(e), 1.0, 16.0) / 15.0 for e in eta]
    v = np.linspace(0.0, 1.0, 201)
    curves = {
        "s": np.array([base_error_s(v, b, n_bar0) for b in n_bar]),
        "t": np.array([base_error_t(v, b, n_bar0) for b in n_bar]),
        "log t": np.array([base_error_log_t(v, b, n_bar0) for b in n_bar]),
    }
    figure, axes = plt.subplots(1, 3, figsize=(12, 3.8), sharey=True)
    for axis, (name, values) in zip(axes[:2], list(curves.items())[:2], strict=True):
        axis.semilogy(eta, values[:, 0], label="v = 0")
        axis.semilogy(eta, values[:, -1], label="v = 1")
        axis.semilogy(eta, values.min(axis=1), "k:", label="least over v")
        named(axis, f"M̃_p,{name} (LogPSM fig. 5.6)", "η", f"M̃_{name}")
    for name, color in (("t", "C0"), ("log t", "C2")):
        storage = curves["s"].max(axis=1) * curves[name].max(axis=1)
        axes[2].semilogy(eta, storage, color, label="S_p, perspective" if name == "t" else "S_lp, log+perspective")
    named(axes[2], "Storage factor (LogPSM fig. 5.6)", "η", "S")
    save(figure, "5_6_error_over_warps")


def partition_schemes() -> None:
    """LogPSM figure 5.20: m_x m_z along the view for the four z-partition schemes, uniform and warped (f/n = 1000, 4 maps)."""
    far, phi = 1000.0, radians(30)
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.0), sharey=True)
    for axis, kind in zip(axes, ("uniform", "lispsm"), strict=True):
        for scheme, color in (("z-log", "C0"), ("z-linear", "C3"), ("z-pssm", "C1"), ("z-pseudo-near", "C2")):
            splits = split_distances(PartitionChoice(scheme, 4), 1.0, far, OVERHEAD).tolist()
            for i, (n, f) in enumerate(zip(splits[:-1], splits[1:], strict=True)):
                m = WarpedMap(n, f, phi, OVERHEAD, inf if kind == "uniform" else lispsm_parameter(n, f))
                z = np.geomspace(n, f, 200)
                axis.loglog(z, error_x(m, z) * error_z(m, z), color=color, label=scheme if i == 0 else None)
        axis.axhline(log1p(far - 1.0) / (2 * tan(phi)), color="k", ls="--", lw=0.8, label="logarithmic (49)")
        named(axis, f"m_x m_z, 4 maps, {kind} (LogPSM fig. 5.20)", "z", "m_x m_z")
    save(figure, "5_20_partition_schemes")


def light_directions() -> None:
    """Not in the texts: M_x and the seen M_z over γ for every warp, one map (f/n = 100, φ = 30°)."""
    gamma = np.radians(np.linspace(0.5, 90.0, 360))
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.0))
    for kind in WARPS:
        maps = [partition_maps(NEAR, FAR, radians(30), float(g), WarpChoice(kind), PartitionChoice("none"))[0] for g in gamma]
        for axis, largest in zip(axes, (max_error_x, max_beam_error_z), strict=True):
            axis.semilogy(np.degrees(gamma), [largest(m) for m in maps], label=kind)
    for axis, name in zip(axes, ("M_x", "M_z as seen, (37) · sin γ"), strict=True):
        axis.axvline(degrees(gamma_lim_rad(NEAR, FAR, radians(30))), color="k", lw=0.6, ls=":")
        named(axis, f"{name}, f/n = 100, φ = 30°", "γ in degrees", name)
    save(figure, "light_directions")


def main() -> None:
    """Draw them all."""
    for draw in (
        error_along_the_view,
        maxima_over_eta,
        generalised_parameter,
        error_over_gamma,
        storage_over_ratio,
        base_errors,
        error_over_warps,
        partition_schemes,
        light_directions,
    ):
        draw()


if __name__ == "__main__":
    main()
