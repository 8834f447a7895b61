//! What pushes a free vehicle from outside and the plant does not know: ground under its legs, air that moves.

use sil_host::plant::Truth;
use sil_host::sensors::random::RandomStream;

/// Of the legs about the centre of gravity: forward and sideways, and down, m.
const LEG_M: [f64; 2] = [0.12, 0.10];
/// From this height on air moves up and down as it does far from the ground, at which it can't; m.
const FREE_AIR_M: f64 = 5.0;
/// Slower than this friction holds in proportion, m/s.
const STICKS_M_S: f64 = 0.02;

/// A plane that carries legs as springs with dampers do, with friction.
#[derive(Clone, Copy, Debug)]
pub struct Ground {
    /// How far the vehicle was above it at the start, centre of gravity, m.
    pub below_m: f64,
    /// It falls away to the north by this angle.
    pub slope_deg: f64,
    /// How far it yields under the vehicle's weight, m.
    pub yields_m: f64,
    /// Damping ratio of the vehicle on it.
    pub damping: f64,
    pub friction: f64,
}

impl Ground {
    /// Legs and arms of plastic on a floor: they bend by 10 mm.
    pub const FLAT: Ground = Ground { below_m: 5.0, slope_deg: 0.0, yields_m: 0.01, damping: 0.3, friction: 0.7 };

    /// So far below that nobody meets it.
    pub const NONE: Ground = Ground { below_m: 1e6, ..Ground::FLAT };
}

/// Air about it. The vertical part acts through the rotors' inflow: at one speed they lift more the faster they sink
/// (Leishman, Principles of Helicopter Aerodynamics, 2nd ed., 2.13 and 3.3: with 10 inches at 500 rad/s and 5.5 m/s of
/// induced velocity 5 % per m/s).
#[derive(Clone, Copy, Debug)]
pub struct Air {
    /// Lift over vertical airspeed, over the mass, 1/s.
    pub inflow_1_s: f64,
    /// Drag over the square of the vertical airspeed, over the mass, 1/m.
    pub drag_1_m: f64,
    /// Over horizontal airspeed, over the mass, 1/s; what the plant has of it in still air.
    pub rotor_drag_1_s: f64,
    /// Steady velocity upwards, m/s.
    pub up_m_s: f64,
    /// Gusts about each axis: standard deviation, m/s, and how long they last, s.
    pub gust_m_s: f64,
    pub gust_s: f64,
}

impl Air {
    pub const STILL: Air =
        Air { inflow_1_s: 0.5, drag_1_m: 0.0, rotor_drag_1_s: 0.3, up_m_s: 0.0, gust_m_s: 0.0, gust_s: 1.0 };
}

impl Air {
    /// A gust's speed a time later: a first-order Markov process.
    pub fn next_gust_m_s(&self, gust_m_s: f64, after_us: u64, draws: &mut RandomStream) -> f64 {
        if self.gust_m_s == 0.0 {
            return 0.0;
        }
        let keeps = (-1e-6 * after_us as f64 / self.gust_s).exp();
        keeps * gust_m_s + (1.0 - keeps * keeps).sqrt() * self.gust_m_s * draws.normal()
    }
}

/// Sum of the forces (body, N), and their torque (body, N m).
pub type Push = ([f64; 3], [f64; 3]);

/// Of legs on a plane, for a vehicle of this mass.
pub fn of_ground(ground: &Ground, mass_kg: f64, truth: &Truth) -> Push {
    let per_leg = 0.25 * mass_kg;
    let frequency_rad_s = (9.81 / ground.yields_m).sqrt();
    let stiffness_n_m = per_leg * frequency_rad_s * frequency_rad_s;
    let damping_ns_m = 2.0 * ground.damping * per_leg * frequency_rad_s;
    let (sin, cos) = ground.slope_deg.to_radians().sin_cos();
    let up = [sin, 0.0, -cos];
    let (mut force_body_n, mut torque_body_nm) = ([0.0; 3], [0.0; 3]);
    for (forward, right) in [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
        let leg = [forward * LEG_M[0], right * LEG_M[0], LEG_M[1]];
        let arm = to_world(truth, leg);
        let swing = to_world(truth, cross(truth.rate_body_rad_s, leg));
        let place: [f64; 3] = std::array::from_fn(|i| truth.position_ned_m[i] + arm[i]);
        let velocity: [f64; 3] = std::array::from_fn(|i| truth.velocity_ned_m_s[i] + swing[i]);
        let above_m = dot(up, [place[0], place[1], place[2] - ground.below_m - LEG_M[1]]);
        let away_m_s = dot(up, velocity);
        let normal_n = -stiffness_n_m * above_m - damping_ns_m * away_m_s;
        if above_m >= 0.0 || normal_n <= 0.0 {
            continue;
        }
        let along: [f64; 3] = std::array::from_fn(|i| velocity[i] - away_m_s * up[i]);
        let slip_m_s = dot(along, along).sqrt().max(STICKS_M_S);
        let world: [f64; 3] = std::array::from_fn(|i| normal_n * (up[i] - ground.friction * along[i] / slip_m_s));
        let push = to_body(truth, world);
        let torque = cross(leg, push);
        for axis in 0..3 {
            force_body_n[axis] += push[axis];
            torque_body_nm[axis] += torque[axis];
        }
    }
    (force_body_n, torque_body_nm)
}

/// How far the centre of gravity is above where it is with the legs on the ground.
pub fn height_m(ground: &Ground, truth: &Truth) -> f64 {
    let (sin, cos) = ground.slope_deg.to_radians().sin_cos();
    sin * truth.position_ned_m[0] + cos * (ground.below_m - truth.position_ned_m[2])
}

/// Of air that moves by `gust_m_s` (north, east, up) beside what is steady, at a height above ground, body, N.
pub fn of_air(air: &Air, mass_kg: f64, truth: &Truth, gust_m_s: [f64; 3], height_m: f64) -> [f64; 3] {
    let free = (height_m / FREE_AIR_M).clamp(0.0, 1.0);
    let moves = [gust_m_s[0], gust_m_s[1], -free * (air.up_m_s + gust_m_s[2])];
    let air_body = to_body(truth, moves);
    let velocity_body = to_body(truth, truth.velocity_ned_m_s);
    let against_m_s = velocity_body[2] - air_body[2];
    let down = -mass_kg * (air.inflow_1_s + air.drag_1_m * against_m_s.abs()) * against_m_s;
    let along = mass_kg * air.rotor_drag_1_s;
    [along * air_body[0], along * air_body[1], down]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn to_world(truth: &Truth, v: [f64; 3]) -> [f64; 3] {
    rotated(truth.q_world_from_body, v)
}

fn to_body(truth: &Truth, v: [f64; 3]) -> [f64; 3] {
    let [w, x, y, z] = truth.q_world_from_body;
    rotated([w, -x, -y, -z], v)
}

fn rotated([w, x, y, z]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let once = cross([x, y, z], v);
    let twice = cross([x, y, z], once);
    std::array::from_fn(|i| v[i] + 2.0 * (w * once[i] + twice[i]))
}
