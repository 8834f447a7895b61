//! How well a flight followed its reference: the figures that `sil fly` prints, defined in docs/commands.md.
//!
//! A step is a change of an axis' reference, returns included. Errors are the true angle against the raw reference.

use serde::Serialize;

/// Band that counts as settled, rad.
const SETTLED_RAD: f64 = 3.0 * std::f64::consts::PI / 180.0;
/// Time before the next step over which the steady error is taken, s.
const STEADY_S: f64 = 0.25;
/// From so long after a step on its error is late, s.
const LATE_S: f64 = 1.0;

/// Figures of one axis over a whole flight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AxisMetrics {
    /// Time from 10 to 90 % of a step, s, mean over the steps; none if a step never gets there or there is no step.
    pub rise_time_s: Option<f64>,
    /// Largest excursion past the target in % of the step, mean over the steps.
    pub overshoot_pct: Option<f64>,
    /// Time until the error stays within 3 degrees, s, mean over the steps; none if one never settles.
    pub settling_time_s: Option<f64>,
    /// Mean |error| over the last 0.25 s before the next step, degrees, mean over the steps.
    pub steady_error_deg: Option<f64>,
    /// Largest |error| from 1 s after a step to the next, and from 1 s after the start to the first, degrees; none of a
    /// flight without such a time.
    pub largest_late_error_deg: Option<f64>,
    /// Mean |error| over the flight, degrees.
    pub mean_abs_error_deg: f64,
    /// Root mean square of the error over the flight, degrees.
    pub rms_error_deg: f64,
}

/// One step of a reference: samples `begin..end`, from one angle to another.
struct Step {
    begin: usize,
    end: usize,
    from_rad: f64,
    to_rad: f64,
}

/// Figures of an axis from its series, all of one length and evenly or unevenly sampled.
pub fn axis_metrics(time_s: &[f64], reference_rad: &[f64], angle_rad: &[f64]) -> AxisMetrics {
    let steps = steps_of(reference_rad);
    let errors: Vec<f64> = angle_rad.iter().zip(reference_rad).map(|(angle, reference)| angle - reference).collect();
    let mean_over_steps = |figure: &dyn Fn(&Step) -> Option<f64>| {
        let figures: Option<Vec<f64>> = steps.iter().map(figure).collect();
        figures.filter(|figures| !figures.is_empty()).map(|figures| mean(&figures))
    };
    AxisMetrics {
        rise_time_s: mean_over_steps(&|step| rise_time(step, time_s, angle_rad)),
        overshoot_pct: mean_over_steps(&|step| Some(overshoot_pct(step, angle_rad))),
        settling_time_s: mean_over_steps(&|step| settling_time(step, time_s, &errors)),
        steady_error_deg: mean_over_steps(&|step| Some(steady_error(step, time_s, &errors).to_degrees())),
        largest_late_error_deg: largest_late_error(&steps, time_s, &errors).map(f64::to_degrees),
        mean_abs_error_deg: mean(&errors.iter().map(|error| error.abs()).collect::<Vec<_>>()).to_degrees(),
        rms_error_deg: mean(&errors.iter().map(|error| error * error).collect::<Vec<_>>()).sqrt().to_degrees(),
    }
}

/// Mean over time and motors of |command - base|.
pub fn effort(commands: &[[f64; 4]], base: f64) -> f64 {
    mean(&commands.iter().map(|motors| motors.iter().map(|c| (c - base).abs()).sum::<f64>() / 4.0).collect::<Vec<_>>())
}

/// Samples with any motor at a limit, %.
pub fn saturated_pct(commands: &[[f64; 4]]) -> f64 {
    let at_limit = |motors: &&[f64; 4]| motors.iter().any(|&c| c <= 0.0 || c >= 1.0);
    100.0 * commands.iter().filter(at_limit).count() as f64 / commands.len().max(1) as f64
}

/// Arithmetic mean; zero of nothing.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn steps_of(reference_rad: &[f64]) -> Vec<Step> {
    let changes: Vec<usize> = (1..reference_rad.len()).filter(|&i| reference_rad[i] != reference_rad[i - 1]).collect();
    let ends = changes.iter().skip(1).copied().chain([reference_rad.len()]);
    changes
        .iter()
        .zip(ends)
        .map(|(&begin, end)| Step { begin, end, from_rad: reference_rad[begin - 1], to_rad: reference_rad[begin] })
        .collect()
}

fn rise_time(step: &Step, time_s: &[f64], angle_rad: &[f64]) -> Option<f64> {
    let crossed = |share: f64| {
        let size = step.to_rad - step.from_rad;
        (step.begin..step.end).find(|&i| (angle_rad[i] - step.from_rad) / size >= share).map(|i| time_s[i])
    };
    Some(crossed(0.9)? - crossed(0.1)?)
}

fn overshoot_pct(step: &Step, angle_rad: &[f64]) -> f64 {
    let size = step.to_rad - step.from_rad;
    let past = angle_rad[step.begin..step.end].iter().map(|angle| (angle - step.to_rad) / size);
    100.0 * past.fold(0.0, f64::max)
}

/// None if the last sample of the step is still outside.
fn settling_time(step: &Step, time_s: &[f64], errors: &[f64]) -> Option<f64> {
    match (step.begin..step.end).rev().find(|&i| errors[i].abs() > SETTLED_RAD) {
        Some(last) if last + 1 == step.end => None,
        Some(last) => Some(time_s[last + 1] - time_s[step.begin]),
        None => Some(0.0),
    }
}

fn steady_error(step: &Step, time_s: &[f64], errors: &[f64]) -> f64 {
    let end_s = time_s[step.end - 1];
    let last: Vec<f64> =
        (step.begin..step.end).filter(|&i| time_s[i] > end_s - STEADY_S).map(|i| errors[i].abs()).collect();
    mean(&last)
}

fn largest_late_error(steps: &[Step], time_s: &[f64], errors: &[f64]) -> Option<f64> {
    let first = steps.first().map_or(errors.len(), |step| step.begin);
    let stretches = [(0, first)].into_iter().chain(steps.iter().map(|step| (step.begin, step.end)));
    let late = stretches.flat_map(|(begin, end)| (begin..end).filter(move |&i| time_s[i] >= time_s[begin] + LATE_S));
    late.map(|i| errors[i].abs()).max_by(f64::total_cmp)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// First-order response with time constant 0.1 s to a step of 0.5 rad at 1 s, back at 3 s.
    fn first_order() -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let time: Vec<f64> = (0..5000).map(|k| f64::from(k) * 0.001).collect();
        let reference: Vec<f64> = time.iter().map(|&t| if (1.0..3.0).contains(&t) { 0.5 } else { 0.0 }).collect();
        let angle = time
            .iter()
            .map(|&t| match t {
                t if t < 1.0 => 0.0,
                t if t < 3.0 => 0.5 * (1.0 - (-(t - 1.0) / 0.1).exp()),
                t => 0.5 * (-(t - 3.0) / 0.1).exp(),
            })
            .collect();
        (time, reference, angle)
    }

    #[test]
    fn first_order_step_has_its_textbook_figures() {
        let (time, reference, angle) = first_order();
        let m = axis_metrics(&time, &reference, &angle);
        // 10 to 90 % in tau ln 9; 3 degrees of 0.5 rad after tau ln(0.5 / 0.05236); resolution one sample of 1 ms
        assert!((m.rise_time_s.unwrap() - 0.1 * 9f64.ln()).abs() < 0.0021);
        assert!((m.settling_time_s.unwrap() - 0.1 * (0.5 / SETTLED_RAD).ln()).abs() < 0.0021);
        assert!(m.overshoot_pct.unwrap() < 1e-9);
        assert!(m.steady_error_deg.unwrap() < 1e-4);
        // e^-10 of the step is left 1 s after it
        assert!((m.largest_late_error_deg.unwrap() - 0.5f64.to_degrees() * (-10f64).exp()).abs() < 1e-6);
        // integral of the squared error: two steps of 0.25 * tau / 2 over 5 s
        let rms = (2.0 * 0.25 * 0.05 / 5.0f64).sqrt().to_degrees();
        assert!((m.rms_error_deg / rms - 1.0).abs() < 0.02);
    }

    #[test]
    fn overshoot_is_counted_past_the_target_only() {
        let (time, reference, mut angle) = first_order();
        angle[2500] = 0.6;
        angle[4500] = -0.05;
        let m = axis_metrics(&time, &reference, &angle);
        // 20 % and 10 %
        assert!((m.overshoot_pct.unwrap() - 15.0).abs() < 1e-9);
    }

    #[test]
    fn a_step_that_never_settles_is_said_so() {
        let (time, reference, _) = first_order();
        let m = axis_metrics(&time, &reference, &vec![0.2; time.len()]);
        assert_eq!((m.settling_time_s, m.rise_time_s), (None, None));
        let still = axis_metrics(&time, &vec![0.0; time.len()], &vec![0.0; time.len()]);
        assert_eq!((still.settling_time_s, still.overshoot_pct), (None, None));
    }

    #[test]
    fn effort_and_saturation() {
        let commands = [[0.5, 0.5, 0.5, 0.5], [1.0, 0.0, 0.5, 0.5]];
        assert_eq!(effort(&commands, 0.5), 0.125);
        assert_eq!(saturated_pct(&commands), 50.0);
    }
}
