"""Small scenarios that several tests share."""

FLAT = {
    "name": "flat",
    "seed": 3,
    "world": {"type": "ring", "n": 12, "radius": 6.0},
    "time": {"dt": 0.5, "last": 50},
    "robot": [
        {
            "motion": "unicycle",
            "position": [0.0, -4.0],
            "v": 1.0,
            "w_deg": 14.4,
            "v_std": 0.05,
            "w_std_deg": 1.0,
        }
    ],
    "sensor": [{"type": "range_bearing", "range_std": 0.1, "bearing_std_deg": 1.0, "max_range": 6.0}],
    "landmark": {"type": "euc_pnt"},
}

SPACE = {
    "name": "space",
    "seed": 4,
    "world": {"type": "cloister"},
    "time": {"last": 12},
    "robot": [
        {
            "motion": "odometry3",
            "position": [0.0, -5.0, 0.0],
            "dx": [0.08, 0.0, 0.0],
            "da_deg": [0.0, 0.0, 0.9],
            "dx_std": 0.005,
            "da_std_deg": 0.05,
        }
    ],
    "sensor": [{"type": "pin_hole", "position": [0, 0, 0.6], "orientation_deg": [-90, 0, -90], "pixel_std": 1.0}],
    "landmark": {"type": "idp_pnt"},
    "options": {"n_inits": [10, 1], "md2_threshold": 9.0},
}
