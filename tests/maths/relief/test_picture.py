"""Picture errors against their definitions in plain loops."""

import numpy as np
import pytest

from addon.maths.relief.picture import C1, C2, WINDOW, picture_errors, psnr_db, ssim_map


def test_ssim_is_wangs_formula_window_by_window(rng):
    a, b = rng.uniform(0, 1, (12, 15)), rng.uniform(0, 1, (12, 15))
    found, reach = ssim_map(a, b), WINDOW // 2
    for y in range(reach, 12 - reach):
        for x in range(reach, 15 - reach):
            p, q = (i[y - reach : y + reach + 1, x - reach : x + reach + 1] for i in (a, b))
            covariance = ((p - p.mean()) * (q - q.mean())).mean()
            expected = (
                (2 * p.mean() * q.mean() + C1) * (2 * covariance + C2) / ((p.mean() ** 2 + q.mean() ** 2 + C1) * (p.var() + q.var() + C2))
            )
            assert found[y, x] == pytest.approx(expected, abs=1e-9)


def test_equal_pictures_are_perfect_and_noise_costs_what_psnr_says(rng):
    picture, shown = rng.uniform(0.2, 0.8, (30, 40, 3)), np.ones((30, 40), bool)
    same = picture_errors(picture, picture, shown, shown)
    assert (same.psnr_db, same.silhouette_iou, same.missing_pct, same.false_pct) == (np.inf, 1.0, 0.0, 0.0)
    assert same.ssim == pytest.approx(1.0)
    noisy = picture + 0.01 * rng.choice([-1.0, 1.0], picture.shape)
    assert psnr_db(noisy, picture) == pytest.approx(40.0, abs=1e-6)
    assert picture_errors(noisy, picture, shown, shown).ssim < 1.0


def test_only_the_union_of_the_silhouettes_counts():
    truth, picture = np.zeros((10, 10, 3)), np.zeros((10, 10, 3))
    picture[0, 0] = 1.0
    true_shown, shown = np.zeros((10, 10), bool), np.zeros((10, 10), bool)
    true_shown[4:8, 4:8] = True
    shown[4:8, 5:9] = True
    found = picture_errors(picture, truth, shown, true_shown)
    assert found.psnr_db == np.inf
    assert found.silhouette_iou == pytest.approx(12 / 20)
    assert found.missing_pct == found.false_pct == 25.0


def test_two_empty_pictures_have_no_error_to_speak_of():
    empty = np.zeros((8, 8), bool)
    assert np.isnan(picture_errors(np.zeros((8, 8, 3)), np.zeros((8, 8, 3)), empty, empty).psnr_db)
