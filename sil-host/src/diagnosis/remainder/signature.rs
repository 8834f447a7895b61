//! On which measured quantity the remainder depends. Moments of general shapes, none of them in the catalogue, are
//! tried beside the findings: on each axis the angle's square and cube (not yaw's in the air), the rate's and slow
//! changes with time, each motor's lift squared, all lifts with time. The one that explains most is reported as the
//! remainder's signature: its quantity and shape, not the name of an effect.

use std::sync::Arc;

use crate::axis::Axis;
use crate::diagnosis::fitting::fit::{Fit, model_of, regular};
use crate::diagnosis::fitting::hints::hints;
use crate::diagnosis::fitting::linearisation::{Normal, normal_beside};
use crate::diagnosis::fitting::shifted::{Moved, Shifted, shifted_models};
use crate::diagnosis::search::{Candidate, Search};
use crate::prediction::body::{Moment, Motion};

use crate::statistics::{Cholesky, decimals, dot};
use crate::vehicle::signed_sums;

/// Fall of the sum of squares, in units of the remaining sum per degree of freedom, that a shape must bring: a chance
/// of 1e-5 over all of them.
const SIGNIFICANT: f64 = 30.0;
/// Change of a coefficient for a difference quotient, N m per unit of the shape; the prediction is linear in it.
const STEP: f64 = 1e-3;
/// Half waves over the log's length.
const HALF_WAVES: [f64; 3] = [1.0, 2.0, 3.0];

/// A moment per unit of a coefficient, about the three axes.
type PerUnit = Arc<dyn Fn(&Motion) -> [f64; 3] + Sync + Send>;

/// A shape, and how it is reported.
struct Shape {
    words: &'static str,
    /// What its coefficient is per, behind the unit of a moment.
    per: &'static str,
    moment: PerUnit,
}

/// Shapes that depend on one quantity.
struct Dependence {
    place: String,
    quantity: &'static str,
    shapes: Vec<Shape>,
}

/// A shape with a coefficient.
struct Scaled {
    moment: PerUnit,
    by: f64,
}

impl Moment for Scaled {
    fn add(&self, motion: &Motion, moment: &mut [f64; 3]) {
        let more = (self.moment)(motion);
        (0..3).for_each(|axis| moment[axis] += self.by * more[axis]);
    }
}

/// The signature of what the chosen effects leave, fitted to all windows; `None` if no shape explains anything of it.
pub(in crate::diagnosis) fn strongest(search: &Search<'_>, chosen: &Candidate<'_>, whole: &Fit<'_>) -> Option<String> {
    let shooting = search.shooting;
    let terms = &whole.terms;
    let driven = shooting.log.drive(model_of(search.nominal, terms));
    let all = shooting.log.in_use();
    let own = shifted_models(shooting, search.nominal, terms, 0);
    let linear = shooting.linearise(&driven, &own, &all, &whole.starts, None);
    let explained_by_own = explained(&linear.normal()).map_or(0.0, |(fall, _)| fall);
    let eliminated = linear.eliminated();
    let mut best: Option<(f64, String)> = None;
    for dependence in dependences(search) {
        let with = |(place, shape): (usize, &Shape)| {
            let mut model = model_of(search.nominal, terms);
            model.moments.push(Box::new(Scaled { moment: Arc::clone(&shape.moment), by: STEP }));
            Shifted { driven: shooting.log.drive(model), numbers: vec![Moved { place, step: STEP, axis: None }] }
        };
        let shifted: Vec<Shifted> = dependence.shapes.iter().enumerate().map(with).collect();
        let extra = shooting.slopes_of(&linear, &shifted, &all, &whole.starts);
        let normal = normal_beside(&eliminated, &extra);
        let Some((fall, coefficients)) = explained(&normal) else { continue };
        // a shape more explains one unit more by chance
        let fall = (fall - explained_by_own) / search.spread(chosen) - dependence.shapes.len() as f64;
        if fall > SIGNIFICANT && best.as_ref().is_none_or(|(most, _)| fall > *most) {
            let first = coefficients.len() - dependence.shapes.len();
            // separate axes are bodies of unit inertia
            let moment_unit = if shooting.log.is_vehicle() { "N m" } else { "rad/s^2" };
            best = Some((fall, dependence.in_words(&normal, &coefficients, first, moment_unit)));
        }
    }
    best.map(|(_, words)| words)
}

/// The strongest frequency of what is missing on an axis, in words.
pub(in crate::diagnosis) fn frequency(search: &Search<'_>, whole: &Fit<'_>, axis: Axis) -> Option<String> {
    let driven = search.shooting.log.drive(model_of(search.nominal, &whole.terms));
    let frequency_hz = hints(&search.shooting.log, &driven).frequency_hz[axis.index()]?;
    Some(format!("strongest in frequency near {frequency_hz:.2} Hz"))
}

/// How far all parameters together would lower the sum of squares, and their steps.
fn explained(normal: &Normal) -> Option<(f64, Vec<f64>)> {
    let size = normal.right.len();
    let factor = Cholesky::new(&regular(&normal.matrix, size, 1e-9), size)?;
    let steps = factor.solve(&normal.right);
    Some((dot(&steps, &normal.right), steps))
}

impl Dependence {
    /// The shape that contributes most, and its sign.
    fn in_words(&self, normal: &Normal, coefficients: &[f64], first: usize, moment_unit: &str) -> String {
        let size = coefficients.len();
        let weight = |i: usize| coefficients[i] * coefficients[i] * normal.matrix[i * size + i];
        let most = (first..size).max_by(|a, b| weight(*a).total_cmp(&weight(*b))).unwrap_or(first);
        let (shape, per) = self.shapes.get(most - first).map_or(("", ""), |shape| (shape.words, shape.per));
        let sign = if coefficients[most] < 0.0 { "minus " } else { "" };
        let size = three_digits(coefficients[most].abs());
        format!(
            "{}: the remainder depends on the {}: a moment proportional to {sign}{shape} ({size} {moment_unit}{per})",
            self.place, self.quantity
        )
    }
}

/// A positive number as people write it.
fn three_digits(value: f64) -> String {
    if (1e-3..1e4).contains(&value) { format!("{value:.*}", decimals(value, 3, 5)) } else { format!("{value:.2e}") }
}

fn dependences(search: &Search<'_>) -> Vec<Dependence> {
    let shooting = search.shooting;
    let rows = shooting.log.rows();
    let (begin_s, end_s) = (rows.first().copied().unwrap_or_default(), rows.last().copied().unwrap_or_default());
    let phase = move |time_s: f64| core::f64::consts::PI * (time_s - begin_s) / (end_s - begin_s);
    let mut all = Vec::new();
    for axis in Axis::ALL.into_iter().filter(|axis| shooting.log.turns(*axis)) {
        let i = axis.index();
        let on_axis = move |value: f64| -> [f64; 3] { core::array::from_fn(|k| if k == i { value } else { 0.0 }) };
        let shape = |words, per, of: fn(&Motion, usize) -> f64| Shape {
            words,
            per,
            moment: Arc::new(move |m| on_axis(of(m, i))),
        };
        let dependence = |quantity, shapes| Dependence { place: axis.name().to_owned(), quantity, shapes };
        let angle = vec![
            shape("its square", " per rad^2", |m, i| m.angle_rad[i] * m.angle_rad[i]),
            shape("its cube", " per rad^3", |m, i| m.angle_rad[i] * m.angle_rad[i] * m.angle_rad[i]),
        ];
        let rate = vec![
            shape("its square, signed", " per (rad/s)^2", |m, i| m.rate_rad_s[i] * m.rate_rad_s[i].abs()),
            shape("its cube", " per (rad/s)^3", |m, i| m.rate_rad_s[i] * m.rate_rad_s[i] * m.rate_rad_s[i]),
        ];
        let time = HALF_WAVES.map(|waves| Shape {
            words: "a slow wave over the log",
            per: "",
            moment: Arc::new(move |m: &Motion| on_axis(libm::cos(waves * phase(m.time_s)))),
        });
        // in the air no moment knows where north is, and a rig that a vehicle's model knows has no yaw
        if axis != Axis::Yaw || !shooting.log.is_vehicle() && !shooting.log.is_of_unknown_flyer() {
            all.push(dependence("angle", angle));
        }
        all.push(dependence("rate", rate));
        all.push(dependence("time", time.into()));
    }
    if shooting.log.is_vehicle() {
        for motor in 0..4 {
            let squared = move |m: &Motion| {
                let of_motor = |i: usize| if i == motor { m.force[motor] * m.force[motor] } else { 0.0 };
                tilt(core::array::from_fn(of_motor))
            };
            let shapes = vec![Shape {
                words: "the square of its lift",
                per: " per N^2 and m of lever",
                moment: Arc::new(squared),
            }];
            all.push(Dependence { place: format!("motor {}", motor + 1), quantity: "command", shapes });
        }
        let fading = HALF_WAVES.map(|waves| Shape {
            words: "all lifts, in a slow wave over the log",
            per: " per N and m of lever",
            moment: Arc::new(move |m: &Motion| {
                let wave = libm::cos(waves * phase(m.time_s));
                tilt(m.force).map(|moment| wave * moment)
            }),
        });
        all.push(Dependence {
            place: "all motors".to_owned(),
            quantity: "command and the time",
            shapes: fading.into(),
        });
    }
    all
}

/// The moment of the motors' forces about roll and pitch, per meter of their lever.
fn tilt(forces: [f64; 4]) -> [f64; 3] {
    let [roll, pitch, _] = signed_sums(forces);
    [roll, pitch, 0.0]
}
