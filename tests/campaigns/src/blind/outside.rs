//! What no catalogue has: moments that the test itself computes from the true motion and puts on the simulated body,
//! tick by tick of the IMU's clock (1 kHz and more), beside the plant and its effects.

use sil_host::plant::Plant;
use sil_host::sensors::random::RandomStream;

/// Where the motors of docs/rig.md sit and turn: signs of the torque of their lifts about (x, y).
const TILT_SIGNS: [[f64; 2]; 4] = [[-1.0, 1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, -1.0]];
/// Lever of each motor about x and y, m: 0.226 m / sqrt 2.
const LEVER_M: f64 = 0.226 * core::f64::consts::FRAC_1_SQRT_2;

/// How a thing of no catalogue behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A spring that stiffens with the cube of the angle.
    CubicSpring,
    /// Friction with a memory (Dahl, 1968): it builds up over 0.15 rad and stays when the motion ends.
    Hysteresis,
    /// Motors that get hot under load, with 10 s, and lift less.
    HotMotors,
    /// An arm that gives way under more than so much lift.
    LooseArm,
    /// Drag with the rate's square.
    SquareDrag,
    /// A stop of rubber beyond 0.3 rad on one side.
    Stop,
    /// Gusts: a moment that wanders at random, with 0.4 s.
    Gusts,
}

const KINDS: [Kind; 7] =
    [Kind::CubicSpring, Kind::Hysteresis, Kind::HotMotors, Kind::LooseArm, Kind::SquareDrag, Kind::Stop, Kind::Gusts];

/// A thing of no catalogue, but for its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outside {
    /// How it behaves.
    pub kind: Kind,
    /// Roll (0) or pitch (1).
    axis: usize,
    /// Motor, 0 to 3.
    motor: usize,
}

impl Outside {
    /// All kinds equally often.
    pub fn draw(seed: u64, draws: &mut RandomStream) -> Outside {
        Outside {
            kind: KINDS[(seed % KINDS.len() as u64) as usize],
            axis: usize::from(draws.uniform() < 0.5),
            motor: (draws.uniform() * 4.0) as usize,
        }
    }

    /// In words.
    pub fn label(&self) -> String {
        let place = match self.kind {
            Kind::HotMotors => String::new(),
            Kind::LooseArm => format!(" {}", self.motor + 1),
            _ => format!(" {}", ["roll", "pitch"][self.axis]),
        };
        format!("{:?}{place}", self.kind)
    }

    /// Does a signature say where it acts, and on which measured quantity what is left depends?
    pub fn is_named_by(&self, signature: &str) -> bool {
        let place = match self.kind {
            Kind::HotMotors => String::new(),
            Kind::LooseArm => format!("motor {}:", self.motor + 1),
            _ => format!("{}:", ["roll", "pitch"][self.axis]),
        };
        let quantities: &[&str] = match self.kind {
            Kind::CubicSpring | Kind::Stop => &["angle"],
            Kind::SquareDrag => &["rate"],
            Kind::Hysteresis => &["angle", "rate"],
            Kind::LooseArm => &["command"],
            Kind::HotMotors => &["time"],
            Kind::Gusts => &["time", "from row to row"],
        };
        signature.starts_with(&place) && quantities.iter().any(|quantity| signature.contains(quantity))
    }

    /// A size to begin with.
    pub(super) fn first_size(&self) -> f64 {
        match self.kind {
            Kind::CubicSpring | Kind::Stop => 0.2,
            Kind::HotMotors | Kind::LooseArm => 0.05,
            Kind::Hysteresis | Kind::SquareDrag | Kind::Gusts => 0.01,
        }
    }

    /// What it puts on the body: a probe of `cosim::fly`.
    pub(super) fn at_work(self, size: f64, seed: u64) -> impl FnMut(&Plant) -> [f64; 3] {
        let mut state = State { moment_nm: 0.0, heat: [0.0; 4], last_s: 0.0 };
        let mut chance = RandomStream::new(seed, "gusts");
        move |plant| {
            let truth = plant.truth();
            let passed_s = (truth.time_s - state.last_s).max(0.0);
            state.last_s = truth.time_s;
            let angle_rad = [truth.roll_rad, truth.pitch_rad][self.axis];
            let rate_rad_s = truth.euler_rate_rad_s[self.axis];
            let about_axis_nm = match self.kind {
                Kind::CubicSpring => -size * angle_rad.powi(3),
                Kind::Hysteresis => state.dahl(size, rate_rad_s, passed_s),
                Kind::SquareDrag => -size * rate_rad_s * rate_rad_s.abs(),
                Kind::Stop => -size * (angle_rad - 0.3).max(0.0),
                Kind::Gusts => state.gust(size, chance.normal(), passed_s),
                Kind::HotMotors => return state.hot(size, &truth.lift_n, passed_s),
                Kind::LooseArm => return loose(size, &truth.lift_n, self.motor),
            };
            // the gimbal's pitch axis in body axes: it takes tau_y cos(roll) - tau_z sin(roll)
            let (sin, cos) = truth.roll_rad.sin_cos();
            if self.axis == 0 { [about_axis_nm, 0.0, 0.0] } else { [0.0, about_axis_nm * cos, -about_axis_nm * sin] }
        }
    }
}

/// What some kinds remember.
struct State {
    moment_nm: f64,
    heat: [f64; 4],
    last_s: f64,
}

impl State {
    fn dahl(&mut self, most_nm: f64, rate_rad_s: f64, passed_s: f64) -> f64 {
        const BUILD_UP_RAD: f64 = 0.15;
        let toward_nm = -most_nm * rate_rad_s.signum();
        self.moment_nm += (toward_nm - self.moment_nm) * (rate_rad_s.abs() * passed_s / BUILD_UP_RAD).min(1.0);
        self.moment_nm
    }

    fn gust(&mut self, size_nm: f64, normal: f64, passed_s: f64) -> f64 {
        const MEMORY_S: f64 = 0.4;
        let kept = (-passed_s / MEMORY_S).exp();
        self.moment_nm = kept * self.moment_nm + size_nm * (1.0 - kept * kept).sqrt() * normal;
        self.moment_nm
    }

    /// Each motor loses a share of its lift in proportion to its heat, which follows the lift's square over that of 1.3
    /// N.
    fn hot(&mut self, size: f64, lift_n: &[f64; 4], passed_s: f64) -> [f64; 3] {
        const WARM_UP_S: f64 = 10.0;
        let mut torque_nm = [0.0; 3];
        for (motor, (lift_n, heat)) in lift_n.iter().zip(&mut self.heat).enumerate() {
            let load = lift_n * lift_n / (1.3 * 1.3);
            *heat += (load - *heat) * passed_s / WARM_UP_S;
            add(&mut torque_nm, motor, -size * *heat * lift_n);
        }
        torque_nm
    }
}

/// Above 1.3 N the arm bends, and a share of the further lift is lost.
fn loose(size: f64, lift_n: &[f64; 4], motor: usize) -> [f64; 3] {
    let mut torque_nm = [0.0; 3];
    add(&mut torque_nm, motor, -10.0 * size * (lift_n[motor] - 1.3).max(0.0));
    torque_nm
}

fn add(torque_nm: &mut [f64; 3], motor: usize, lift_n: f64) {
    torque_nm[0] += TILT_SIGNS[motor][0] * LEVER_M * lift_n;
    torque_nm[1] += TILT_SIGNS[motor][1] * LEVER_M * lift_n;
}
