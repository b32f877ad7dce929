"""The results as tables: the same cells for the terminal and for docs/benchmarks-tracking.md."""


def number(value: float | None, digits: int = 2) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


def markdown(columns: list[str], rows: list[list[str]], left: int = 1) -> str:
    """A table whose first `left` columns are text."""
    alignment = ["---"] * left + ["---:"] * (len(columns) - left)
    lines = [columns, alignment, *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines).replace("| ---", "|---")


def sequences(results: list[dict]) -> str:
    rows = []
    for result in results:
        if "error" in result:
            rows.append([result["sequence"], result["error"], *[""] * 8])
            continue
        for row in result["rows"]:
            rows.append(
                [
                    result["sequence"],
                    row["system"],
                    number(row["ate_mm"]),
                    number(row["rpe_mm"]),
                    number(row["rpe_deg"], 3),
                    str(row["num_failed"]),
                    number(row["median_ms"]),
                    number(row["p95_ms"]),
                    number(row["cv2_rgb_ratio"], 1),
                    str(row.get("num_keyframes", "")),
                ]
            )
    columns = ["sequence", "system", "ATE mm", "RPE mm", "RPE °", "lost", "ms median", "ms p95",
               "faster than cv2 RGB", "keyframes"]  # fmt: skip
    return markdown(columns, rows, 2)


def speed(result: dict) -> str:
    if "error" in result:
        return result["error"]
    whole = markdown(
        ["whole frames", "ms median", "ms p95", "faster than cv2 RGB", "keyframe frames, ms",
         "keyframes", "point evaluations", "ATE mm", "RPE mm"],
        [
            [
                row["system"],
                number(row["median_ms"]),
                number(row["p95_ms"]),
                number(row["cv2_rgb_ratio"], 1),
                number(row["keyframe_median_ms"]),
                str(row["num_keyframes"]),
                f"{row['point_evaluations']:.0f}",
                number(row["ate_mm"]),
                number(row["rpe_mm"]),
            ]
            for row in result["odometry"]
        ],
    )  # fmt: skip
    names = {
        "inverse_depth": "depth image to inverse depth and variance",
        "frame": "frame without depth (image pyramid, gradients)",
        "frame_with_depth": "frame with depth (both pyramids)",
        "keyframe_points": "points of levels 1 to 4",
        "keyframe_setup": "keyframe set-up in all (depth, frame with depth, points)",
    }
    stages = markdown(
        ["stage", "ms median"],
        [[text, number(result["stages"][name])] for name, text in names.items()],
    )
    passes = markdown(
        ["alignment of prepared frames", "budget", "ms", "ns per point evaluation",
         "bytes per point", "ns if only memory counted", "level: points, evaluations"],
        [
            [
                row["system"],
                str(row["max_points"] or "all"),
                number(row["align_median_ms"]),
                number(row["ns_per_point_evaluation"], 1),
                str(row["bytes_per_point"]),
                number(row["bytes_per_point"] / result["triad_gb_per_s"], 1),
                "; ".join(
                    f"{x['level']}: {x['points']:.0f}, {x['evaluations']:.1f}"
                    for x in row["levels"]
                ),
            ]
            for row in result["passes"]
        ],
    )  # fmt: skip
    bound = f"Memory: {result['triad_gb_per_s']:.1f} GB/s (triad, one thread)."
    return "\n\n".join([whole, stages, passes, bound])


def accuracy(rows: list[dict]) -> str:
    cells = [
        [
            row["scene"],
            f"{100 * row['motion'][0]:.1f} cm, {row['motion'][1]:.1f}°",
            row["system"],
            f"{row['num_ok']}/{row['tries']}",
            str(row["num_ok_but_wrong"]),
            str(row["num_within_bound"]),
            number(row["median_mm"], 4),
            number(row["max_mm"], 4),
            number(row["median_deg"], 5),
            number(row["max_deg"], 5),
        ]
        for row in rows
    ]
    columns = ["scene", "motion", "system", "OK", "OK but wrong", "within 0.1 mm, 0.003°",
               "median mm", "max mm", "median °", "max °"]  # fmt: skip
    return markdown(columns, cells, 3)


def basin(result: dict) -> str:
    cells = [
        [
            row["gradient"],
            f"{row['successes']}/{row['starts']}",
            str(row["ok"]),
            str(row["ok_but_not_there"]),
            number(row["goal_mm"], 4),
            number(row["goal_deg"], 5),
        ]
        for row in result["rows"]
    ]
    columns = ["gradient", "successes", "status OK", "OK outside the goal", "goal mm", "goal °"]
    return markdown(columns, cells)


def pairs(rows: list[dict]) -> str:
    cells = [
        [
            f"{row['pair']}{', broken' if row['broken'] else ''}",
            str(row["finest_level"]),
            row["status"],
            number(row["mm"]),
            number(row["deg"], 3),
            f"{row['bounds'][0]:g} mm, {row['bounds'][1]:g}°",
            "yes" if row["within"] else "no",
            number(row["residual_ratio"], 4),
        ]
        for row in rows
    ]
    columns = ["pair", "finest level", "status", "mm", "°", "bound", "within", "residual ratio"]
    return markdown(columns, cells, 3)


def honesty(rows: list[dict]) -> str:
    cells = [
        [
            row["case"],
            row["mode"],
            f"{row['num_ok']}/{row['seeds']}",
            ", ".join(f"{name} {count}" for name, count in sorted(row["statuses"].items())),
        ]
        for row in rows
    ]
    return markdown(["input", "mode", "OK", "statuses"], cells, 2)


def robustness(rows: list[dict]) -> str:
    cells = [
        [
            row["case"],
            row["mode"],
            str(row["num_frames"]),
            str(row["num_ok"]),
            str(row["num_lost"]),
            str(row["num_violations"]),
            number(row["median_mm"]),
            number(row["max_mm"], 1),
            number(row["max_deg"]),
        ]
        for row in rows
    ]
    columns = ["sequence", "mode", "frames", "OK", "lost", "OK but beyond the bound", "median mm",
               "max mm", "max °"]  # fmt: skip
    return markdown(columns, cells, 2)
