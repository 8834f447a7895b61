// Which keys of a tuning have a slider, in groups; names and meanings are the library's. A factor multiplies what
// follows from the vehicle; a value stands for itself, and begins at what the library says.
const factor = (key) => ({ key, isFactor: true, slider: [0.1, 10], range: [0, 1000] });
const value = (key, least, most, step) => ({ key, slider: [least, most], range: [least, most], step });

export const TUNING = {
  pid: [
    factor("angle_gain_1_s"),
    factor("rate_proportional_1_s"),
    factor("rate_integral_1_s2"),
    factor("rate_derivative"),
    value("acceleration_feed_forward", 0, 1.5),
  ],
  mpc: [
    factor("mpc_tracking_weight"),
    factor("mpc_increment_weight"),
    factor("mpc_lead_s"),
    value("mpc_horizon", 1, 30, 1),
    value("mpc_prediction_step_s", 0.002, 0.05),
    value("mpc_disturbance_bandwidth_rad_s", 0, 30),
  ],
  limits: [
    factor("shaping_gain_1_s"),
    factor("acceleration_share"),
    factor("rate_max_rad_s"),
    value("tilt_max_rad", 0.1, 1.5),
    value("gyro_cutoff_hz", 5, 200),
  ],
};

// The groups that a controller has.
export const GROUPS = { pid: ["pid", "limits"], mpc: ["mpc", "limits"] };
