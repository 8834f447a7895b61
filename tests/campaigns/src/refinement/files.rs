//! The bench's files as its owner would write them: readings with scatter, some of them wrong.

use sil_host::refinement::Bench;
use sil_host::sensors::random::RandomStream;

use super::Drawn;

/// Share of rows of which one field is wrong: a drop-out, or a reading of twice the value.
const WRONG: f64 = 0.03;
/// Ripple of the speed, by the six steps of commutation.
const RIPPLE: f64 = 0.003;
const STEP_S: f64 = 0.01;

struct Writer {
    random: RandomStream,
    text: String,
}

impl Writer {
    fn new(seed: u64, header: &str) -> Self {
        Self { random: RandomStream::new(seed, header), text: format!("{header}\n") }
    }

    /// A reading with scatter by a share of it and by an amount.
    fn read(&mut self, truth: f64, share: f64, amount: f64) -> f64 {
        truth + truth * share * self.random.normal() + amount * self.random.normal()
    }

    /// A row; `may_be_wrong` are the fields of which now and then one is.
    fn row(&mut self, mut fields: Vec<f64>, may_be_wrong: &[usize]) {
        if !may_be_wrong.is_empty() && self.random.uniform() < WRONG {
            let which = may_be_wrong[(self.random.uniform() * may_be_wrong.len() as f64) as usize];
            fields[which] *= if self.random.uniform() < 0.5 { 0.0 } else { 2.0 };
        }
        let fields: Vec<String> = fields.iter().map(|field| format!("{field:.8e}")).collect();
        self.text += &format!("{}\n", fields.join(","));
    }

    fn bench(&self, name: &str) -> Bench {
        Bench::parse(&self.text, name).unwrap_or_else(|error| panic!("{error}"))
    }
}

impl Drawn {
    /// All files of the bench.
    ///
    /// # Panics
    /// A file that it writes is refused.
    pub fn benches(&self) -> Vec<Bench> {
        vec![self.winding(), self.alternating(), self.speed_controller(), self.turning(), self.steps()]
    }

    fn winding(&self) -> Bench {
        let mut file = Writer::new(self.seed, "winding_a,winding_v");
        for ampere in 1..=12 {
            let ampere = f64::from(ampere);
            let volt = file.read(self.device.resistance_ohm * ampere, 0.005, 0.001);
            file.row(vec![ampere, volt], &[1]);
        }
        file.bench("winding.csv")
    }

    fn alternating(&self) -> Bench {
        let mut file = Writer::new(self.seed, "ac_hz,ac_a,ac_v");
        for index in 1..=12 {
            let hertz = 500.0 * f64::from(index);
            let reactance = core::f64::consts::TAU * hertz * self.device.inductance_h;
            let volt = file.read(self.device.resistance_ohm.hypot(reactance), 0.005, 0.0);
            file.row(vec![hertz, 1.0, volt], &[2]);
        }
        file.bench("ac.csv")
    }

    fn speed_controller(&self) -> Bench {
        let mut file = Writer::new(self.seed, "command,motor_v");
        for index in 0..=24 {
            let command = f64::from(index) / 24.0;
            let volt = file.read(self.device.voltage_v(command), 0.003, 0.02);
            file.row(vec![command, volt], &[1]);
        }
        file.bench("esc.csv")
    }

    /// The motor with its propeller at 24 voltages, and without at 16.
    fn turning(&self) -> Bench {
        let mut file = Writer::new(self.seed, "propeller,motor_v,current_a,speed_rad_s,lift_n,torque_nm");
        let full_v = self.device.voltage_v(1.0);
        for index in 1..=40 {
            let has_propeller = index <= 24;
            let share = if has_propeller { f64::from(index) / 24.0 } else { f64::from(index - 24) / 16.0 };
            let mut device = self.device;
            if !has_propeller {
                device.drag_nm_s2 = 0.0;
            }
            let volt = full_v * (0.2 + 0.8 * share);
            let (speed, ampere) = device.equilibrium(volt);
            let on = if has_propeller { 1.0 } else { 0.0 };
            let lift_n = on * self.device.lift_n(speed) + self.tare[0];
            let torque_nm = on * self.device.reaction_torque_nm_s2 * speed * speed + self.tare[1];
            let fields = vec![
                on,
                file.read(volt, 0.002, 0.0),
                file.read(ampere, 0.01, 0.005),
                file.read(speed, 0.002, 0.0),
                file.read(lift_n, 0.005, 0.005),
                file.read(torque_nm, 0.01, 1e-4),
            ];
            file.row(fields, &[2, 3, 4, 5]);
        }
        file.bench("turning.csv")
    }

    /// A staircase up and one down, 1.5 s each step, with a lag that differs by the direction.
    fn steps(&self) -> Bench {
        let mut file = Writer::new(self.seed, "time_s,command,speed_rad_s");
        let stairs = [3, 4, 5, 6, 7, 8, 9, 10, 8, 7, 6, 5, 4, 3].map(|tenth| 0.1 * f64::from(tenth));
        let mut speed = 1000.0 * stairs[0];
        for (index, command) in stairs.into_iter().enumerate() {
            for row in 0..150_u32 {
                let target = 1000.0 * command;
                let lag_s = if target > speed { self.lag_s[0] } else { self.lag_s[1] };
                speed = target + (speed - target) * (-STEP_S / lag_s).exp();
                let measured = file.read(speed, RIPPLE, 0.0);
                let time_s = STEP_S * (150.0 * index as f64 + f64::from(row));
                file.row(vec![time_s, command, measured], &[2]);
            }
        }
        file.bench("steps.csv")
    }
}
