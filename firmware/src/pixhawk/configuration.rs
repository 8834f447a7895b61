//! The owner's choices out of the FRAM, and all that follows from them at start.

use core::mem::MaybeUninit;

use shared_control::config::Controller;
use shared_control::link::{Commander, LinkSettings, VehicleStatus};
use shared_control::mpc::{HORIZON, Mpc};
use shared_control::params::{self, Params, RecordError};
use shared_control::radio::Pilot;
use shared_control::sensing::imu::AxisMap;
use shared_control::setup::Setup;
use shared_control::signals::{ArmingBlocks, MotorCommands};

use super::board;
use super::fram::Fram;

/// Room for every control horizon that can be chosen.
pub type BoardMpc = Mpc<HORIZON>;
/// Where it lies; 41 KB, which the stack has no room for.
pub type MpcPlace = MaybeUninit<BoardMpc>;

/// Writes an MPC into its place, whose plans are not solved until it is prepared.
#[inline(never)]
pub fn unprepared(place: &'static mut MpcPlace) -> &'static mut BoardMpc {
    place.write(Mpc::unprepared())
}

/// How this board is set up at its start.
pub struct Configuration {
    /// What was chosen, or the defaults.
    pub params: Params,
    /// What was wrong with the record, if the defaults stand in for it.
    pub fault: Option<RecordError>,
    /// What it means.
    pub setup: Setup,
}

impl Configuration {
    /// What the memory holds.
    pub fn read(memory: &mut Fram) -> Self {
        let (params, fault) = params::load(&memory.read());
        // not `expect`, which would print the error and bring the formatting of floats into the image
        let Ok(setup) = Setup::new(&params) else { panic!("choices of a whole record can be flown") };
        Self { params, fault, setup }
    }

    /// The MPC, prepared where it flies. Not inlined: the 30 KB of stack that it takes to prepare are gone when it
    /// returns, and who flies the cascade never needs them.
    #[inline(never)]
    pub fn mpc(&self, place: &'static mut MpcPlace) -> &'static mut BoardMpc {
        let mpc = unprepared(place);
        if self.params.controller == Controller::Mpc
            && mpc.prepare_in_place(self.params.control_horizon.into(), &self.setup.mpc).is_err()
        {
            panic!("every control horizon can be prepared");
        }
        mpc
    }

    /// Compare value of the disarmed pulse.
    pub fn disarmed_count(&self) -> u16 {
        self.setup.config.output.compare_counts(&MotorCommands::default(), false)[0]
    }

    /// Identity, what the sticks mean, and what TELEM1 carries.
    pub fn link_settings(&self) -> LinkSettings {
        // ten bits a byte
        LinkSettings::of(&self.params, self.link_baud() / 10)
    }

    /// Who takes the ground's and the pilot's wishes, with what stands against arming.
    pub fn commander(&self, fault_record_unread: bool) -> Commander {
        let blocks = ArmingBlocks {
            fault_record_unread,
            configuration_unconfirmed: self.fault.is_some(),
            esc_calibration: self.params.esc_calibration,
            radio_unusable: self.setup.radio.is_err(),
            vehicle_unusable: self.setup.vehicle_fault.is_some(),
            ..ArmingBlocks::default()
        };
        let pilot = self.setup.radio.ok().flatten().map(Pilot::new);
        Commander::new(&self.link_settings(), blocks).with_radio(pilot, self.params.safety_button)
    }

    /// Bits per second on the link.
    pub fn link_baud(&self) -> u32 {
        match (self.params.hil, self.params.telem1_kbaud) {
            (true, _) => board::HIL_BAUD,
            (false, 115) => 115_200,
            (false, _) => 57_600,
        }
    }

    /// The second IMU's gyro was found to sit like this; passes it on.
    pub fn fit_second_gyro(&mut self, axes: Option<AxisMap>) -> Option<AxisMap> {
        if let Some(axes) = axes {
            self.setup.config.sensing.imu_second.gyro_axes = axes;
        }
        axes
    }

    /// Ticks of the loop per housekeeping.
    pub fn housekeeping_ticks(&self) -> u32 {
        u32::from(self.params.loop_rate_hz / board::HOUSEKEEPING_HZ)
    }

    /// What is reported before the first step.
    pub fn status_at_start(&self) -> VehicleStatus {
        let (hil, radio_flies) = (self.params.hil, self.params.radio.flies);
        VehicleStatus { hil, radio_flies, ..VehicleStatus::at_start(self.params.controller) }
    }
}
