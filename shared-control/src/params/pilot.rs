//! The owner's choices for how the sticks feel: how far they reach in each mode, and how.

use super::allowed::Allowed;

/// One number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PilotPart {
    /// [`PilotParams::tilt_deg`].
    Tilt,
    /// [`PilotParams::yaw_deg_s`].
    YawRate,
    /// [`PilotParams::expo_percent`].
    Expo,
    /// [`PilotParams::acro_tilt_deg_s`].
    AcroTiltRate,
    /// [`PilotParams::acro_yaw_deg_s`].
    AcroYawRate,
    /// [`PilotParams::acro_expo_percent`].
    AcroExpo,
    /// [`PilotParams::throttle_mid_percent`].
    ThrottleMid,
    /// [`PilotParams::throttle_expo_percent`].
    ThrottleExpo,
}

/// The choices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PilotParams {
    /// Stabilise: roll and pitch at full stick, degrees.
    pub tilt_deg: u8,
    /// Stabilise: rate of the heading at full stick, degrees per second.
    pub yaw_deg_s: u16,
    /// Stabilise: share of a cube in the curves of roll, pitch and yaw, percent.
    pub expo_percent: u8,
    /// Acro: rates of roll and pitch at full stick, degrees per second.
    pub acro_tilt_deg_s: u16,
    /// Acro: rate of yaw at full stick, degrees per second.
    pub acro_yaw_deg_s: u16,
    /// Acro: share of a cube in the curves of all three, percent.
    pub acro_expo_percent: u8,
    /// Throttle in the middle of its stick, percent.
    pub throttle_mid_percent: u8,
    /// Share of a cube in the throttle's curve about the middle, percent.
    pub throttle_expo_percent: u8,
}

impl PilotParams {
    /// 30 degrees (ArduPilot's ANGLE_MAX), one turn in six seconds; acro at half a turn a second with ArduPilot's
    /// ACRO_RP_EXPO; a straight throttle, as Betaflight's thr_mid 50 and thr_expo 0.
    pub const DEFAULT: PilotParams = PilotParams {
        tilt_deg: 30,
        yaw_deg_s: 60,
        expo_percent: 0,
        acro_tilt_deg_s: 180,
        acro_yaw_deg_s: 90,
        acro_expo_percent: 30,
        throttle_mid_percent: 50,
        throttle_expo_percent: 0,
    };

    /// A number.
    pub(super) fn get(&self, part: PilotPart) -> u16 {
        match part {
            PilotPart::Tilt => self.tilt_deg.into(),
            PilotPart::YawRate => self.yaw_deg_s,
            PilotPart::Expo => self.expo_percent.into(),
            PilotPart::AcroTiltRate => self.acro_tilt_deg_s,
            PilotPart::AcroYawRate => self.acro_yaw_deg_s,
            PilotPart::AcroExpo => self.acro_expo_percent.into(),
            PilotPart::ThrottleMid => self.throttle_mid_percent.into(),
            PilotPart::ThrottleExpo => self.throttle_expo_percent.into(),
        }
    }

    /// Changes a number, to what the table allows.
    pub(super) fn set(&mut self, part: PilotPart, value: u16) {
        match part {
            PilotPart::Tilt => self.tilt_deg = value as u8,
            PilotPart::YawRate => self.yaw_deg_s = value,
            PilotPart::Expo => self.expo_percent = value as u8,
            PilotPart::AcroTiltRate => self.acro_tilt_deg_s = value,
            PilotPart::AcroYawRate => self.acro_yaw_deg_s = value,
            PilotPart::AcroExpo => self.acro_expo_percent = value as u8,
            PilotPart::ThrottleMid => self.throttle_mid_percent = value as u8,
            PilotPart::ThrottleExpo => self.throttle_expo_percent = value as u8,
        }
    }
}

/// Name, range, unit and meaning. Rates end where the rate loop's targets do (5 and 2 rad/s), tilts below them.
pub(super) const fn row(part: PilotPart) -> (&'static str, Allowed, &'static str, &'static str) {
    match part {
        PilotPart::Tilt => ("PILOT_TILT_DEG", Allowed::Range(10, 60), "deg", "stabilise: roll and pitch at full stick"),
        PilotPart::YawRate => {
            ("PILOT_Y_RATE", Allowed::Range(10, 114), "deg/s", "stabilise: turning rate at full stick")
        }
        PilotPart::Expo => (
            "PILOT_EXPO_PCT",
            Allowed::Range(0, 100),
            "%",
            "stabilise: share of a cube in the sticks' curves; 0 is straight",
        ),
        PilotPart::AcroTiltRate => {
            ("ACRO_RP_RATE", Allowed::Range(10, 286), "deg/s", "acro: rate of roll and pitch at full stick")
        }
        PilotPart::AcroYawRate => ("ACRO_Y_RATE", Allowed::Range(10, 114), "deg/s", "acro: rate of yaw at full stick"),
        PilotPart::AcroExpo => {
            ("ACRO_EXPO_PCT", Allowed::Range(0, 100), "%", "acro: share of a cube in the sticks' curves")
        }
        PilotPart::ThrottleMid => ("THR_MID_PCT", Allowed::Range(20, 80), "%", "throttle in the middle of its stick"),
        PilotPart::ThrottleExpo => (
            "THR_EXPO_PCT",
            Allowed::Range(0, 100),
            "%",
            "share of a cube in the throttle's curve: the more, the finer about the middle",
        ),
    }
}
