//! The owner's choices, where there is time for them: served, stored, brought into use, and words about each.

use core::fmt::{Display, Write};

use mavlink::dialects::common::{MavCmd, MavSeverity};
use nalgebra::Vector3;

use super::Telemetry;
use crate::exchange::Senseless;
use crate::link::orders_and_answers::{Answer, ParameterRequest, Text};
use crate::link::vehicle_status::VehicleStatus;
use crate::params::level::LevelParams;
use crate::params::{Params, RECORD_LEN};
use crate::sensing::imu::STANDARD_GRAVITY_M_S2;
use crate::sensing::level_trim::LevelTrim;
use crate::supervisor::Refusal;

impl Telemetry {
    /// Serves the parameters; `store` as in [`Parameters::serve`](crate::link::Parameters::serve).
    pub fn serve_parameters(
        &mut self,
        request: &ParameterRequest,
        status: &VehicleStatus,
        store: impl FnOnce(&[u8; RECORD_LEN]) -> bool,
    ) {
        if let Some(words) = self.parameters.serve(request, status.arming.is_armed(), store) {
            self.text(MavSeverity::MAV_SEVERITY_NOTICE, &words);
        }
    }

    /// Stores the choices as they are, and says what came of it.
    pub fn store_configuration(&mut self, store: impl FnOnce(&[u8; RECORD_LEN]) -> bool) {
        let kept = self.parameters.store(store);
        let words = if kept { "configuration stored" } else { "configuration not stored: memory failed" };
        self.text(MavSeverity::MAV_SEVERITY_NOTICE, words);
    }

    /// Stores how the IMUs sit on a vehicle that stands still and level, and says what came of it.
    pub fn calibrate_level(&mut self, status: &VehicleStatus, store: impl FnOnce(&[u8; RECORD_LEN]) -> bool) {
        const COMMAND: MavCmd = MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION;
        self.parameters.count_change();
        let [first, second] = status.rest_force_m_s2;
        let trim = |force_m_s2: Vector3<f32>| LevelTrim::of_level_vehicle(&force_m_s2, STANDARD_GRAVITY_M_S2);
        let Some(force_m_s2) = first else { return self.answer(Answer::Refused(COMMAND, Refusal::VehicleMoves)) };
        let Some(found) = trim(force_m_s2) else { return self.answer(Answer::Refused(COMMAND, Refusal::NotLevel)) };
        let second = second.and_then(trim).map(|trim| LevelParams::new(&trim));
        if self.parameters.set_level((LevelParams::new(&found), second), store) {
            self.answer(Answer::Accepted(COMMAND));
            self.text(MavSeverity::MAV_SEVERITY_NOTICE, "level stored");
        } else {
            self.answer(Answer::Busy(COMMAND));
            self.text(MavSeverity::MAV_SEVERITY_WARNING, "level not stored: memory failed");
        }
    }

    /// What is to be brought into use, while nothing flies; none where it is, or where more may come.
    pub fn parameters_wanted(&mut self, time_us: u64) -> Option<&Params> {
        self.parameters.wanted_once_quiet(time_us)
    }

    /// These are in use from now on: says so, and what makes no sense about them.
    pub fn parameters_in_use(&mut self, params: &Params, senseless: &Senseless) {
        let words = self.parameters.now_in_use(params);
        self.text(MavSeverity::MAV_SEVERITY_NOTICE, &words);
        if let Some(fault) = senseless.radio {
            self.warn(fault);
        }
        if let Some(fault) = senseless.vehicle {
            self.warn(fault);
        }
    }

    /// What was wanted can't be flown. None that a record can hold is known to be so.
    pub fn parameters_not_usable(&mut self) {
        self.parameters.not_usable();
        self.text(MavSeverity::MAV_SEVERITY_WARNING, "not in use: these parameters can't be flown");
    }

    /// How many changes of parameters the commander need not wait for; see
    /// [`Parameters::settled`](crate::link::Parameters::settled).
    pub fn parameters_settled(&mut self, status: &VehicleStatus) -> u8 {
        self.parameters.settled(status.arming.is_armed())
    }

    /// Tells a person something that should not be so.
    pub fn warn(&mut self, words: impl Display) {
        let mut text = Text::new();
        // what does not fit is left out
        let _ = write!(text, "{words}");
        self.text(MavSeverity::MAV_SEVERITY_WARNING, &text);
    }
}
