"""The arithmetic of benchmarks/track.py: what it publishes must be what it measured."""

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from raylign import geometry, synthetic
from raylign.camera import PinholeCamera
from raylign.trajectory import Trajectory

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"
XI = np.array([0.02, -0.01, 0.03, 0.02, -0.01, 0.015])


@pytest.fixture(autouse=True)
def _harness_on_the_path(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))


def test_steps_chain_to_the_poses_they_came_from():
    from tracking import frames

    _, T_wc = synthetic.trajectory("handheld", n=6, seed=1)
    steps = [np.linalg.inv(b) @ a for a, b in pairwise(T_wc)]
    np.testing.assert_allclose(frames.chain(steps), T_wc, atol=1e-12)


def test_score_is_in_millimetres_and_skips_frames_without_a_pose():
    from tracking import frames

    stamps, T_wc = synthetic.trajectory("handheld", n=9, seed=2)
    found = T_wc.copy()
    found[1::2, 0, 3] += 0.002
    found[8] = np.nan
    score = frames.score(stamps, found, Trajectory(stamps, T_wc))
    assert score["num_poses"] == 8
    assert score["ate_mm"] == pytest.approx(1.0, rel=0.1)  # ±1 mm about the fit
    assert score["rpe_mm"] == pytest.approx(2.0, rel=1e-3)


@pytest.mark.parametrize("size", [1e-7, 1.0])
def test_pose_error_is_distance_and_angle(size):
    from tracking import frames

    T = geometry.se3_exp(0.1 * XI)
    moved = T @ geometry.se3_exp(size * np.array([0, 0, 0, 0, 0.3, 0.4]))
    metres, degrees = frames.pose_error(moved, T)
    assert metres == pytest.approx(0.0, abs=1e-12)
    assert degrees == pytest.approx(np.degrees(0.5 * size), rel=1e-6)


def test_random_motions_have_the_length_and_angle_asked_for():
    from tracking import accuracy, frames

    T = accuracy.motion(0.084, 3.5, np.random.default_rng(3))
    assert np.linalg.norm(T[:3, 3]) == pytest.approx(0.084)
    assert frames.pose_error(T, np.eye(4))[1] == pytest.approx(3.5)


def test_an_ok_far_from_the_truth_is_counted_as_wrong():
    from tracking import accuracy

    summary = accuracy.summarise([(True, 5e-5, 0.001), (True, 0.2, 8.0), (False, 0.2, 8.0)])
    assert summary["num_ok"] == 2
    assert summary["num_ok_but_wrong"] == 1
    assert summary["num_within_bound"] == 1


def test_residuals_of_a_pair_vanish_at_the_true_pose():
    from tracking import pairs

    camera = PinholeCamera(130.0, 130.0, 79.5, 59.5)
    T = geometry.se3_exp(0.5 * XI)
    scene = synthetic.plane(texture=synthetic.TextureOptions())
    exact = synthetic.RenderOptions(antialiasing="none")
    host, target = (
        synthetic.render(scene, camera, pose, width=160, height=120, options=exact)
        for pose in (np.eye(4), T)
    )
    at_truth = pairs.residuals(host.irradiance, host.depth, target.irradiance, camera, T)
    at_start = pairs.residuals(host.irradiance, host.depth, target.irradiance, camera, np.eye(4))
    assert np.isfinite(at_truth).mean() > 0.8
    assert np.nanmean(np.abs(at_truth)) < 0.2 * np.nanmean(np.abs(at_start))


def test_times_and_ratios_are_taken_round_by_round():
    from tracking import sequences

    fast, slow = [0.001, 0.001, 0.002], [0.010, 0.010, 0.020]
    rounds = [
        {
            "raylign": {"seconds": np.multiply(drift, fast), "ate_mm": 1.0},
            sequences.REFERENCE: {"seconds": np.multiply(drift, slow), "ate_mm": 2.0},
        }
        for drift in (1.0, 3.0, 2.0)
    ]
    ours, theirs = sequences.summarise(rounds)
    assert ours["cv2_rgb_ratio"] == pytest.approx(10.0)
    assert theirs["median_ms"] == pytest.approx(20.0)
    assert "seconds" not in ours


def test_a_part_measured_again_leaves_the_others(tmp_path):
    import track

    path = tmp_path / "tracking.json"
    path.write_text(json.dumps(track.merge(path, {"commit": "a"}, {"pairs": [1], "basin": [2]})))
    merged = track.merge(path, {"commit": "b"}, {"pairs": [3]})
    assert merged["pairs"] == {"machine": {"commit": "b"}, "result": [3]}
    assert merged["basin"] == {"machine": {"commit": "a"}, "result": [2]}


def test_a_sequence_measured_again_leaves_the_others(tmp_path):
    import track

    path = tmp_path / "tracking.json"
    earlier = [{"sequence": "a", "ate": 1}, {"sequence": "b", "ate": 2}]
    path.write_text(json.dumps(track.merge(path, {}, {"sequences": earlier, "robustness": []})))
    merged = track.merge(path, {}, {"sequences": [{"sequence": "b", "ate": 3}]})
    assert merged["sequences"]["result"] == [earlier[0], {"sequence": "b", "ate": 3}]
    rows = [{"case": "turn", "mode": mode} for mode in ("photometric", "photometric + depth")]
    path.write_text(json.dumps(track.merge(path, {}, {"robustness": rows})))
    merged = track.merge(path, {}, {"robustness": [rows[1] | {"max_mm": 1.0}]})
    assert merged["robustness"]["result"] == [rows[0], rows[1] | {"max_mm": 1.0}]


def test_robustness_sequences_hold_what_their_names_say():
    from tracking import robustness

    shots = {
        name: next(robustness.render(robustness.CASES[name], 0))
        for name in ("handheld", "exposure drifts, ×0.5 to ×1.6")
    }
    assert shots["handheld"][1].shape == (robustness.HEIGHT, robustness.WIDTH)
    brighter = [image.mean() for image, *_ in shots.values()]
    assert brighter[1] == pytest.approx(1.05 * brighter[0], rel=0.01)
    turned = robustness.trajectory_of(robustness.CASES["camera jumps by 40°"], 0)
    assert np.trace(turned[29][:3, :3].T @ turned[30][:3, :3]) < 2.7
