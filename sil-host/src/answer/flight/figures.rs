//! The figures of a flight with their names and decimals: one list for the terminal and the report.

use crate::flight::RunSummary;
use crate::margins::Margins;
use crate::metrics::AxisMetrics;

/// A number that is shown.
pub struct Figure<T> {
    /// Name with unit.
    pub name: &'static str,
    /// Digits after the point.
    pub decimals: usize,
    /// Where it comes from; none where there is no such number.
    pub value: fn(&T) -> Option<f64>,
}

/// A text that is shown.
pub struct TextFigure<T> {
    /// Name with unit.
    pub name: &'static str,
    /// Where it comes from.
    pub text: fn(&T) -> String,
}

/// How well an axis follows; of all of them less is better.
pub const FOLLOWING: [Figure<AxisMetrics>; 7] = [
    Figure { name: "rise time 10-90 %, s", decimals: 3, value: |m| m.rise_time_s },
    Figure { name: "overshoot, %", decimals: 1, value: |m| m.overshoot_pct },
    Figure { name: "settling time to 3 deg, s", decimals: 3, value: |m| m.settling_time_s },
    Figure { name: "steady error, deg", decimals: 2, value: |m| m.steady_error_deg },
    Figure { name: "largest |error| later than 1 s, deg", decimals: 2, value: |m| m.largest_late_error_deg },
    Figure { name: "mean |error|, deg", decimals: 2, value: |m| Some(m.mean_abs_error_deg) },
    Figure { name: "RMS error, deg", decimals: 2, value: |m| Some(m.rms_error_deg) },
];

/// How robust an axis is.
pub const ROBUSTNESS: [Figure<Margins>; 5] = [
    Figure { name: "gain margin, dB", decimals: 1, value: |m| m.gain_db },
    Figure { name: "phase margin, deg", decimals: 1, value: |m| m.phase_deg },
    Figure { name: "delay margin, ms", decimals: 1, value: |m| m.delay_ms },
    Figure { name: "crossover, Hz", decimals: 2, value: |m| m.crossover_hz },
    Figure { name: "peak sensitivity", decimals: 2, value: |m| Some(m.sensitivity_peak) },
];

/// The flight as a whole. The speed of the simulation is not among them: it is another at every run.
pub const WHOLE_FLIGHT: [TextFigure<RunSummary>; 6] = [
    TextFigure { name: "control steps per second", text: |s| s.rate_hz.to_string() },
    TextFigure { name: "effort (mean |command - base|)", text: |s| format!("{:.4}", s.effort) },
    TextFigure { name: "samples with a motor at a limit, %", text: |s| format!("{:.1}", s.saturated_pct) },
    TextFigure {
        name: "MPC: prediction steps / free inputs",
        text: |s| s.mpc.map_or("-".into(), |m| format!("{} / {}", m.horizon, m.control_horizon)),
    },
    TextFigure {
        name: "MPC: most iterations of a plan",
        text: |s| s.mpc.map_or("-".into(), |m| m.iterations_max.to_string()),
    },
    TextFigure {
        name: "MPC: plans unsolved / steps flown by the cascade",
        text: |s| s.mpc.map_or("-".into(), |m| format!("{} / {}", m.unsolved, m.fallbacks)),
    },
];

/// Eigenvalues in polar form, as text.
pub fn eigenvalues_text(eigenvalues: [[f64; 2]; 4]) -> [String; 4] {
    eigenvalues.map(|[magnitude, angle_rad]| format!("{magnitude:.4} at {:.2} deg", angle_rad.to_degrees()))
}
