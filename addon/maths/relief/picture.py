"""How far a picture with impostors is from the same picture of the geometry: PSNR, SSIM, and the silhouettes. No GPU."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

WINDOW = 7
C1, C2 = 0.01**2, 0.03**2
"""Wang et al. 2004: (0.01 L)², (0.03 L)² for a dynamic range L = 1."""


@dataclass(frozen=True, slots=True)
class PictureErrors:
    """`psnr_db` (infinite when equal) and `ssim` over the union of both silhouettes; `silhouette_iou`; `missing_pct`, `false_pct` of the
    true silhouette's pixels. All NaN where neither picture shows anything."""

    psnr_db: float
    ssim: float
    silhouette_iou: float
    missing_pct: float
    false_pct: float


def picture_errors(picture: np.ndarray, truth: np.ndarray, shown: np.ndarray, true_shown: np.ndarray) -> PictureErrors:
    """Compare images (h, w, 3 or more; linear or display values in 0…1) on the objects' silhouettes (h, w) bool."""
    union, both = shown | true_shown, shown & true_shown
    if not union.any():
        return PictureErrors(np.nan, np.nan, np.nan, np.nan, np.nan)
    a, b = (np.clip(np.asarray(image, np.float64)[..., :3], 0.0, 1.0) for image in (picture, truth))
    true_count = max(int(true_shown.sum()), 1)
    return PictureErrors(
        psnr_db(a, b, union),
        float(ssim_map(a.mean(axis=-1), b.mean(axis=-1))[union].mean()),
        float(both.sum() / union.sum()),
        100.0 * float((true_shown & ~shown).sum()) / true_count,
        100.0 * float((shown & ~true_shown).sum()) / true_count,
    )


def psnr_db(a: np.ndarray, b: np.ndarray, where: np.ndarray | None = None) -> float:
    """−10 log₁₀ of the mean squared difference of images in 0…1 (h, w, c), on the pixels `where` (h, w); infinite when equal."""
    squares = (a - b) ** 2
    mean = float((squares if where is None else squares[where]).mean())
    return float("inf") if mean == 0.0 else -10.0 * float(np.log10(mean))


def ssim_map(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(h, w) structural similarity (Wang et al. 2004) of two grey images in 0…1 with a uniform 7×7 window, mirrored at the borders."""
    mean_a, mean_b = _box(a), _box(b)
    var_a, var_b = np.maximum(_box(a * a) - mean_a**2, 0.0), np.maximum(_box(b * b) - mean_b**2, 0.0)
    covariance = _box(a * b) - mean_a * mean_b
    above = (2.0 * mean_a * mean_b + C1) * (2.0 * covariance + C2)
    return above / ((mean_a**2 + mean_b**2 + C1) * (var_a + var_b + C2))


def _box(image: np.ndarray) -> np.ndarray:
    """Mean over the window round every pixel, by running sums."""
    reach = WINDOW // 2
    padded = np.pad(image, reach, mode="symmetric")
    for axis in (0, 1):
        total = np.cumsum(padded, axis=axis)
        total = np.concatenate([np.zeros_like(np.take(total, [0], axis=axis)), total], axis=axis)
        count = image.shape[axis]
        padded = (np.take(total, range(WINDOW, WINDOW + count), axis=axis) - np.take(total, range(count), axis=axis)) / WINDOW
    return padded
