//! A vehicle written from docs/rig.md and docs/effects.md alone, for tests: rigs, motors and effects by their printed
//! equations, in f64, integrated in steps of 0.1 ms by the classical Runge-Kutta method. It shares no code with the
//! crate.

/// Rows of a log per second, and steps of the integration in each row.
pub const ROW_S: f64 = 5e-3;
const STEPS: usize = 50;
const STEP_S: f64 = ROW_S / STEPS as f64;

pub const GRAVITY_M_S2: f64 = 9.81;
pub const MASS_KG: f64 = 1.2;
pub const INERTIA_KG_M2: [f64; 3] = [0.011, 0.014, 0.02];
pub const RING_KG_M2: f64 = 0.025;
const ARM_M: f64 = 0.226;
const REACTION_M: f64 = 0.02;
/// Lift of a motor over its command: a straight line, at once.
const LIFT_AT_0_N: f64 = -1.0;
const LIFT_SLOPE_N: f64 = 8.0;
/// With rotors: lift over the square of a rotor's speed, and the speed over the command, which hover and lift there as
/// the straight line does.
const LIFT_N_S2: f64 = 1e-5;
const SPEED_AT_0: f64 = 179.0;
const SPEED_SLOPE: f64 = 737.0;

/// The same vehicle as a model file, with rotors that lag by a time constant, s, or, at 0, without.
pub fn model_file(rig: Rig, rotor_lag_s: f64) -> String {
    let (level, propulsion) = if rotor_lag_s > 0.0 {
        let lines = format!(
            "speed_offset_rad_s = {SPEED_AT_0:?}\nspeed_slope_rad_s = {SPEED_SLOPE:?}\n\
             time_constant_s = {rotor_lag_s:?}\nlift_n_s2 = {LIFT_N_S2:?}\n\
             reaction_torque_nm_s2 = {:?}\n",
            REACTION_M * LIFT_N_S2
        );
        ("generic", lines)
    } else {
        let lines = format!(
            "lift_offset_n = {LIFT_AT_0_N:?}\nlift_slope_n = {LIFT_SLOPE_N:?}\n\
             reaction_torque_per_lift_m = {REACTION_M}\n"
        );
        ("box", lines)
    };
    let [ixx, iyy, izz] = INERTIA_KG_M2;
    let (name, body, ring) = match rig {
        Rig::Gimbal => ("gimbal", String::new(), format!("[ring]\ninertia_kg_m2 = {RING_KG_M2}\n")),
        Rig::Free => ("free", format!("mass_kg = {MASS_KG}\n"), String::new()),
    };
    format!(
        "name = \"test\"\nrig = \"{name}\"\nlevel = \"{level}\"\n\
         gravity_m_s2 = {GRAVITY_M_S2}\narm_m = {ARM_M}\nbase_command = {}\n\
         [body]\nixx_kg_m2 = {ixx}\niyy_kg_m2 = {iyy}\nizz_kg_m2 = {izz}\n{body}{ring}\
         [propulsion]\n{propulsion}\
         [noise]\ngyro_rad_s = 0\naccel_m_s2 = 0\nattitude_rad = 0\nvelocity_m_s = 0\nheight_m = 0\n",
        hover()
    )
}

/// Command of hover.
pub fn hover() -> f64 {
    (MASS_KG * GRAVITY_M_S2 / 4.0 - LIFT_AT_0_N) / LIFT_SLOPE_N
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rig {
    Gimbal,
    Free,
}

/// Where it is at a time.
#[derive(Clone, Copy, Debug)]
pub struct Moving {
    pub time_s: f64,
    /// Start of the step of the integration, s: what sets in at its end is not there at its last stage.
    pub step_start_s: f64,
    /// Roll, pitch, yaw.
    pub angle: [f64; 3],
    /// Their derivatives on the gimbal, p, q, r when free.
    pub rate: [f64; 3],
    /// Velocity against the air along the body's axes, m/s.
    pub against: [f64; 3],
    /// Sum of the lifts, N.
    pub lift_n: f64,
    /// Speeds of the rotors and their derivatives; 0 without rotors.
    pub rotor_speed: [f64; 4],
    pub rotor_acceleration: [f64; 4],
}

/// What an effect adds, by its equation in docs/effects.md.
#[derive(Clone, Copy)]
pub struct Page {
    /// Q about roll, pitch and yaw, N m.
    pub moment: fn(&Moving) -> [f64; 3],
    /// Force along the body's axes, N, at a velocity against the air in them, m/s.
    pub force: fn([f64; 3]) -> [f64; 3],
    pub wind: [f64; 3],
    /// Factor on each lift, at a time, the battery's voltage, a height above ground.
    pub lift: fn(f64, f64, f64) -> [f64; 4],
    pub delay_s: f64,
    pub range: [f64; 2],
    pub lag_s: f64,
    /// What a command acts as behind the lag.
    pub acts_as: fn(f64) -> f64,
    /// Time constant of the rotors' speed; 0 where the lift follows the command at once, without rotors.
    pub rotor_lag_s: f64,
    pub inertia: [f64; 3],
    pub product: f64,
    pub mass: f64,
    /// Reported of true angles, and of true p, q, r and specific force.
    pub reported_angle: fn([f64; 3]) -> [f64; 3],
    pub reported_rate: fn([f64; 3]) -> [f64; 3],
    pub reported_force: fn([f64; 3]) -> [f64; 3],
    pub angle_delay_s: f64,
}

/// Nothing.
pub const NOMINAL: Page = Page {
    moment: |_| [0.0; 3],
    force: |_| [0.0; 3],
    wind: [0.0; 3],
    lift: |_, _, _| [1.0; 4],
    delay_s: 0.0,
    range: [0.0, 1.0],
    lag_s: 0.0,
    acts_as: |command| command,
    rotor_lag_s: 0.0,
    inertia: [1.0; 3],
    product: 0.0,
    mass: 1.0,
    reported_angle: |angle| angle,
    reported_rate: |rate| rate,
    reported_force: |force| force,
    angle_delay_s: 0.0,
};

/// One row: what is true, and what was commanded in it.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    pub time_s: f64,
    pub angle: [f64; 3],
    /// p, q, r.
    pub rate: [f64; 3],
    pub specific_force: [f64; 3],
    pub velocity: [f64; 3],
    pub height: f64,
    pub battery_v: f64,
    pub command: [f64; 4],
}

/// Roll, pitch, yaw; their derivatives or p, q, r; velocity; place down; the lagged commands; the rotors' speeds.
type State = [f64; 18];

pub struct Reference {
    rig: Rig,
    page: Page,
    state: State,
    start_height: f64,
    fall_v_s: f64,
    /// Commands by the step in which they are given.
    given: Vec<[f64; 4]>,
}

impl Reference {
    pub fn new(rig: Rig, page: Page, start_height: f64, fall_v_s: f64) -> Self {
        let mut state = [0.0; 18];
        let command = hover().clamp(page.range[0], page.range[1]);
        state[10..14].copy_from_slice(&[command; 4]);
        if page.rotor_lag_s > 0.0 {
            state[14..].copy_from_slice(&[SPEED_AT_0 + SPEED_SLOPE * (page.acts_as)(command); 4]);
        }
        Self { rig, page, state, start_height, fall_v_s, given: Vec::new() }
    }

    fn time(&self) -> f64 {
        self.given.len() as f64 * STEP_S
    }

    fn volts(&self, time_s: f64) -> f64 {
        12.0 - self.fall_v_s * time_s
    }

    /// Commands that have come through the delay, cut to the range.
    fn arrived(&self, command: [f64; 4]) -> [f64; 4] {
        let late = (self.page.delay_s / STEP_S).round() as usize;
        let step = self.given.len();
        let arrived = match late {
            0 => command,
            _ if step < late => [hover(); 4],
            _ => self.given[step - late],
        };
        arrived.map(|command| command.max(self.page.range[0]).min(self.page.range[1]))
    }

    /// The motor's command behind the lag on it.
    fn driving(&self, state: &State, arrived: [f64; 4], motor: usize) -> f64 {
        (self.page.acts_as)(if self.page.lag_s > 0.0 { state[10 + motor] } else { arrived[motor] })
    }

    fn lifts(&self, time_s: f64, state: &State, arrived: [f64; 4]) -> [f64; 4] {
        let factors = (self.page.lift)(time_s, self.volts(time_s), self.start_height - state[9]);
        std::array::from_fn(|motor| {
            let lift = if self.page.rotor_lag_s > 0.0 {
                LIFT_N_S2 * state[14 + motor] * state[14 + motor]
            } else {
                (LIFT_AT_0_N + LIFT_SLOPE_N * self.driving(state, arrived, motor)).max(0.0)
            };
            factors[motor] * lift
        })
    }

    /// docs/rig.md, level `generic`.
    fn rotor_accelerations(&self, state: &State, arrived: [f64; 4]) -> [f64; 4] {
        std::array::from_fn(|motor| {
            let target = (SPEED_AT_0 + SPEED_SLOPE * self.driving(state, arrived, motor)).max(0.0);
            if self.page.rotor_lag_s > 0.0 { (target - state[14 + motor]) / self.page.rotor_lag_s } else { 0.0 }
        })
    }

    /// Velocity against the air along the body's axes.
    fn against(&self, state: &State) -> [f64; 3] {
        turned_back(angles(state), std::array::from_fn(|axis| state[6 + axis] - self.page.wind[axis]))
    }

    /// Specific force along the body's axes.
    fn felt(&self, state: &State, lift_n: f64) -> [f64; 3] {
        let [x, y, z] = (self.page.force)(self.against(state));
        let mass = self.page.mass * MASS_KG;
        [x / mass, y / mass, (z - lift_n) / mass]
    }

    fn derivative(&self, time_s: f64, state: &State, arrived: [f64; 4]) -> State {
        let [f1, f2, f3, f4] = self.lifts(time_s, state, arrived);
        let lift_n = f1 + f2 + f3 + f4;
        let h = ARM_M / std::f64::consts::SQRT_2;
        let tau = [h * (f2 + f3 - f1 - f4), h * (f1 + f3 - f2 - f4), REACTION_M * (f1 + f2 - f3 - f4)];
        let (angle, rate) = (angles(state), [state[3], state[4], state[5]]);
        let rotor_acceleration = self.rotor_accelerations(state, arrived);
        let q = (self.page.moment)(&Moving {
            time_s,
            step_start_s: self.time(),
            angle,
            rate,
            against: self.against(state),
            lift_n,
            rotor_speed: [state[14], state[15], state[16], state[17]],
            rotor_acceleration,
        });
        let mut change = [0.0; 18];
        change[14..].copy_from_slice(&rotor_acceleration);
        if self.page.lag_s > 0.0 {
            for motor in 0..4 {
                change[10 + motor] = (arrived[motor] - state[10 + motor]) / self.page.lag_s;
            }
        }
        match self.rig {
            Rig::Gimbal => self.gimbal(state, tau, q, &mut change),
            Rig::Free => self.free(state, tau, q, lift_n, &mut change),
        }
        change
    }

    /// docs/rig.md, rig A.
    fn gimbal(&self, state: &State, tau: [f64; 3], q: [f64; 3], change: &mut State) {
        let [ixx, iyy, izz] = INERTIA_KG_M2;
        let (phi, dphi, dtheta) = (state[0], state[3], state[4]);
        let (sin, cos) = (phi.sin(), phi.cos());
        let j = self.page.inertia[1] * (RING_KG_M2 + iyy * cos * cos + izz * sin * sin);
        let j_slope = self.page.inertia[1] * 2.0 * (izz - iyy) * sin * cos;
        let p = self.page.product;
        let roll = tau[0] + 0.5 * j_slope * dtheta * dtheta + q[0];
        let pitch = tau[1] * cos - tau[2] * sin - j_slope * dphi * dtheta + p * sin * dphi * dphi + q[1];
        // [a, b; b, j] (phi'', theta'') = (roll, pitch), by Cramer's rule
        let (a, b) = (self.page.inertia[0] * ixx, p * cos);
        change[0] = dphi;
        change[1] = dtheta;
        change[3] = (roll * j - b * pitch) / (a * j - b * b);
        change[4] = (a * pitch - b * roll) / (a * j - b * b);
    }

    /// Rig B: thesis (2.1) to (2.3) with gravity downward.
    fn free(&self, state: &State, tau: [f64; 3], moment: [f64; 3], lift_n: f64, change: &mut State) {
        let [roll, pitch, _] = angles(state);
        let [p, q, r] = [state[3], state[4], state[5]];
        let turn = (q * roll.sin() + r * roll.cos()) / pitch.cos();
        (change[0], change[1], change[2]) = (p + turn * pitch.sin(), q * roll.cos() - r * roll.sin(), turn);
        let inertia: [f64; 3] = std::array::from_fn(|axis| self.page.inertia[axis] * INERTIA_KG_M2[axis]);
        let product = self.page.product;
        let tensor = nalgebra::Matrix3::new(inertia[0], product, 0.0, product, inertia[1], 0.0, 0.0, 0.0, inertia[2]);
        let omega = nalgebra::Vector3::new(p, q, r);
        let torque = nalgebra::Vector3::from(tau) + nalgebra::Vector3::from(moment);
        let acceleration = tensor.lu().solve(&(torque - omega.cross(&(tensor * omega)))).unwrap();
        change[3..6].copy_from_slice(acceleration.as_slice());
        let world = rotation(angles(state)) * nalgebra::Vector3::from(self.felt(state, lift_n));
        change[6..9].copy_from_slice(&[world.x, world.y, world.z + GRAVITY_M_S2]);
        change[9] = state[8];
    }

    /// The row at this time, and the motion on to the next under commands that a controller makes of it.
    pub fn row(&mut self, controller: impl Fn(&Row) -> [f64; 4]) -> Row {
        let (time_s, state) = (self.time(), self.state);
        let rate = match self.rig {
            Rig::Gimbal => [state[3], state[4] * state[0].cos(), -state[4] * state[0].sin()],
            Rig::Free => [state[3], state[4], state[5]],
        };
        // the command before this row's acts until now
        let before = self.given.last().copied().unwrap_or([hover(); 4]);
        let mut row = Row {
            time_s,
            angle: angles(&state),
            rate,
            specific_force: self.felt(&state, self.lifts(time_s, &state, self.arrived(before)).iter().sum()),
            velocity: [state[6], state[7], state[8]],
            height: self.start_height - state[9],
            battery_v: self.volts(time_s),
            command: [0.0; 4],
        };
        row.command = controller(&row);
        for _ in 0..STEPS {
            let (now, from, arrived) = (self.time(), self.state, self.arrived(row.command));
            let at = |k: &State, share: f64| -> State { std::array::from_fn(|i| from[i] + share * STEP_S * k[i]) };
            let k1 = self.derivative(now, &from, arrived);
            let k2 = self.derivative(now + 0.5 * STEP_S, &at(&k1, 0.5), arrived);
            let k3 = self.derivative(now + 0.5 * STEP_S, &at(&k2, 0.5), arrived);
            let k4 = self.derivative(now + STEP_S, &at(&k3, 1.0), arrived);
            self.state = std::array::from_fn(|i| from[i] + STEP_S / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
            self.given.push(row.command);
        }
        row
    }
}

fn angles(state: &State) -> [f64; 3] {
    [state[0], state[1], state[2]]
}

/// World from body: about z, then y, then x.
pub fn rotation([roll, pitch, yaw]: [f64; 3]) -> nalgebra::Matrix3<f64> {
    nalgebra::Rotation3::from_euler_angles(roll, pitch, yaw).into_inner()
}

fn turned_back(angle: [f64; 3], world: [f64; 3]) -> [f64; 3] {
    (rotation(angle).transpose() * nalgebra::Vector3::from(world)).into()
}
