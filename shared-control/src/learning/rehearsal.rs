//! What a controller would do with a vehicle that is not quite the one it is made for, tried on the very code that
//! would fly: the observer, the prediction to the next plan, the MPC's law, in a loop with a body of chosen gain and
//! lag.
//!
//! A short push at the motors' torque goes round the loop; what the motors make of it, push included, is the loop's
//! sensitivity as an impulse response. Its largest Fourier component is the peak sensitivity, and a response that does
//! not die away is a loop that is not stable.

use crate::elementary::{larger, magnitude, sin_cos, sqrt};
use crate::torque_observer::{DisturbanceAlert, ObserverConfig, ObserverState, Pace};
use crate::vehicle::Actuation;

/// How long a push is watched, s.
const WATCHED_S: f32 = 2.5;
/// Frequencies at which the sensitivity is looked at: from the least, each greater by this ratio, rad/s.
const FREQUENCIES: u8 = 48;
const LEAST_RAD_S: f32 = 1.0;
const RATIO: f32 = 1.13;
/// What may be left of the largest response at the end, as a share.
const LEFT_MAX: f32 = 0.02;
/// The push, N m: far from every limit, far from rounding.
const PUSH_NM: f32 = 1e-3;

/// One axis' controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisController {
    /// As [`Mpc::unconstrained_gain`](crate::mpc::Mpc::unconstrained_gain): torque per angle, rate, motors' torque and
    /// previous torque.
    pub law: [f32; 4],
    /// Inertia that it counts on, kg m^2.
    pub inertia_kg_m2: f32,
    /// What it counts on from command to motor, filters of the gyro as far as it knows of them included.
    pub seen: Actuation,
    /// Its observer.
    pub pace: Pace,
}

/// One axis of a vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisBody {
    /// Inertia over what its motors' torque is larger by than commanded, kg m^2.
    pub inertia_kg_m2: f32,
    /// From command to motor, filters of the gyro included.
    pub actuation: Actuation,
}

/// How a loop stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// Peak sensitivity at the motors' torque.
    pub peak_sensitivity: f32,
    /// What is left of a push in the end, over its largest response.
    pub left: f32,
}

impl Standing {
    /// Pushes die away.
    pub fn is_stable(&self) -> bool {
        self.left < LEFT_MAX && self.peak_sensitivity.is_finite()
    }
}

/// A push and its way round the loop; none for a delay beyond what the observer takes.
pub fn rehearse(controller: &AxisController, body: &AxisBody, alert: DisturbanceAlert) -> Option<Standing> {
    let step_s = controller.pace.step_s;
    let observer = observer_of(controller.inertia_kg_m2, &controller.seen, Pace { alert, ..controller.pace })?;
    // an observer without corrections is a body
    let unmoved = Pace { bandwidth_rad_s: 0.0, alert: DisturbanceAlert::Never, step_s };
    let true_body = observer_of(body.inertia_kg_m2, &body.actuation, unmoved)?;
    let mut trial = Trial::default();
    let mut spectrum = Spectrum::new(step_s);
    let steps = (WATCHED_S / step_s) as u32;
    let (mut largest, mut left) = (0.0, 0.0);
    for step in 0..steps {
        let push_nm = if step == 0 { PUSH_NM } else { 0.0 };
        let response_nm = trial.step(&observer, &true_body, &controller.law, push_nm, step_s);
        spectrum.add(response_nm / PUSH_NM);
        largest = larger(largest, magnitude(response_nm));
        left = if step >= steps - steps / 10 { larger(left, magnitude(response_nm)) } else { 0.0 };
    }
    Some(Standing { peak_sensitivity: spectrum.largest(), left: left / largest })
}

fn observer_of(inertia_kg_m2: f32, seen: &Actuation, pace: Pace) -> Option<ObserverConfig> {
    ObserverConfig::new([inertia_kg_m2; 3], [1.0; 3], seen, pace)
}

/// Body, observer and law between two steps.
#[derive(Clone, Copy, Debug, Default)]
struct Trial {
    body: ObserverState,
    seen: ObserverState,
    angle_rad: f32,
    rate_rad_s: f32,
    torque_nm: f32,
}

impl Trial {
    /// One step: what the motors are told, with the push, N m.
    fn step(
        &mut self,
        observer: &ObserverConfig,
        body: &ObserverConfig,
        [angle, rate, motor, previous]: &[f32; 4],
        push_nm: f32,
        step_s: f32,
    ) -> f32 {
        // the torque that the last step's request brought is in force from now on
        let delivered_nm = self.torque_nm;
        let told_nm = delivered_nm + push_nm;
        self.body.update(body, [f32::NAN; 3], [told_nm; 3], [0.0; 3]);
        let [rate_rad_s, ..] = self.body.rate_rad_s();
        self.angle_rad += 0.5 * step_s * (self.rate_rad_s + rate_rad_s);
        self.rate_rad_s = rate_rad_s;
        self.seen.update(observer, [rate_rad_s; 3], [delivered_nm; 3], [0.0; 3]);
        let [then, ..] = self.seen.at_next_plan(observer, [self.angle_rad; 3], [rate_rad_s; 3], [0.0; 3]);
        let [disturbance_nm, ..] = self.seen.disturbance_nm();
        self.torque_nm = angle * then.angle_rad
            + rate * then.rate_rad_s
            + motor * (then.motor_nm + disturbance_nm)
            + previous * (delivered_nm + disturbance_nm)
            - disturbance_nm;
        told_nm
    }
}

/// Fourier components, each turned on by a step's angle.
struct Spectrum {
    components: [Component; FREQUENCIES as usize],
}

#[derive(Clone, Copy, Default)]
struct Component {
    /// Where its unit vector points, and how it turns in a step: cosine and sine.
    pointer: [f32; 2],
    turn: [f32; 2],
    sum: [f32; 2],
}

impl Spectrum {
    fn new(step_s: f32) -> Self {
        let mut frequency_rad_s = LEAST_RAD_S;
        let mut components = [Component::default(); FREQUENCIES as usize];
        for component in &mut components {
            let (sine, cosine) = sin_cos(frequency_rad_s * step_s);
            *component = Component { pointer: [1.0, 0.0], turn: [cosine, sine], sum: [0.0; 2] };
            frequency_rad_s *= RATIO;
        }
        Self { components }
    }

    fn add(&mut self, value: f32) {
        for Component { pointer: [x, y], turn: [cosine, sine], sum: [re, im] } in &mut self.components {
            (*re, *im) = (*re + value * *x, *im - value * *y);
            (*x, *y) = (*x * *cosine - *y * *sine, *x * *sine + *y * *cosine);
        }
    }

    fn largest(&self) -> f32 {
        self.components.iter().map(|Component { sum: [re, im], .. }| sqrt(re * re + im * im)).fold(0.0, larger)
    }
}
