//! From bytes to orders: what the ground wants, checked for address and sense.

// older ground stations ask as is no longer recommended, and are answered
#![allow(deprecated)]

use mavlink::MessageData;
use mavlink::dialects::common::{
    AUTOPILOT_VERSION_DATA, AttitudeTargetTypemask, COMMAND_INT_DATA, COMMAND_LONG_DATA, FILE_TRANSFER_PROTOCOL_DATA,
    HEARTBEAT_DATA, HIL_SENSOR_DATA, MANUAL_CONTROL_DATA, MISSION_REQUEST_LIST_DATA, MavCmd, MavParamType, MavType,
    PARAM_REQUEST_LIST_DATA, PARAM_REQUEST_READ_DATA, PARAM_SET_DATA, SET_ATTITUDE_TARGET_DATA, SETUP_SIGNING_DATA,
    TIMESYNC_DATA,
};
use nalgebra::Quaternion;

use super::file_transfer::FileRequest;
use super::frame::{Frame, FrameFinder, message};
use super::hil::HilTick;
use super::log_download;
use super::mode::Mode;
use super::orders_and_answers::{Inquiry, Order, ParameterRequest};
use super::settings::{COMPONENT_ID, LinkSettings};
use super::signing::{FIRST_TIMESTAMP_MAX, Guard, Key, SigningSetup};
use crate::elementary::limit;
use crate::frames::{euler_from_q, normalized};
use crate::params::table::Field;
use crate::radio::{StickCurves, Sticks};
use crate::signals::{MotorTest, Setpoint};

/// Parameter 2 of `MAV_CMD_COMPONENT_ARM_DISARM` that overrides checks: the message definitions' magic number.
const BY_FORCE: f32 = 21196.0;
/// `MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES`.
const REQUEST_AUTOPILOT_CAPABILITIES: u16 = 520;
/// A larger roll or pitch is no set-point, rad: 60 degrees, the most that a stick can mean.
const OFFBOARD_TILT_MAX_RAD: f32 = core::f32::consts::FRAC_PI_3 + 1e-3;

/// Turns the bytes that arrive into orders.
#[derive(Clone, Debug)]
pub struct Receiver {
    settings: LinkSettings,
    finder: FrameFinder,
    is_local: bool,
    /// Frames with a right CRC and a content that makes no sense: values that don't exist, NaN, invalid axes.
    pub rejected: u32,
}

impl Receiver {
    /// A receiver that has heard nothing.
    pub fn new(settings: LinkSettings) -> Self {
        Self { settings, finder: FrameFinder::default(), is_local: false, rejected: 0 }
    }

    /// The same of a link that only somebody beside the vehicle can use: signing may be set up over it.
    pub fn local(settings: LinkSettings) -> Self {
        Self { is_local: true, ..Self::new(settings) }
    }

    /// What the sticks mean from now on.
    pub fn use_curves(&mut self, curves: &StickCurves) {
        self.settings.curves = *curves;
    }

    /// Takes one byte. A frame that the guard does not admit is as if it had not come.
    pub fn receive(&mut self, byte: u8, guard: &mut Guard) -> Option<Order> {
        let frame = self.finder.push(byte, crc_extra)?;
        if !guard.admits(&frame, self.is_local) {
            return None;
        }
        match frame.message_id {
            HEARTBEAT_DATA::ID => self.heartbeat(&frame),
            MANUAL_CONTROL_DATA::ID => self.manual_control(&frame),
            COMMAND_LONG_DATA::ID | COMMAND_INT_DATA::ID => self.command(&frame),
            SET_ATTITUDE_TARGET_DATA::ID => self.attitude_target(&frame),
            MISSION_REQUEST_LIST_DATA::ID => self.plan_length(&frame),
            TIMESYNC_DATA::ID => self.timesync(&frame),
            SETUP_SIGNING_DATA::ID => self.signing(&frame),
            FILE_TRANSFER_PROTOCOL_DATA::ID => {
                let (address, request) = FileRequest::of(&frame);
                self.is_for_this_component(address[0], address[1]).then_some(Order::Files(request))
            }
            HIL_SENSOR_DATA::ID => {
                let tick = self.counted(message::<HIL_SENSOR_DATA>(&frame).map(|data| HilTick::new(&data)))?;
                // a tick without a sample makes its step, and counts
                self.counted(tick.imu);
                Some(Order::HilTick(tick))
            }
            id if log_download::crc_extra(id).is_some() => self.logs(&frame),
            _ => self.parameters(&frame).map(Order::Parameters),
        }
    }

    /// Bytes that belonged to no frame that is understood.
    pub fn bytes_skipped(&self) -> u32 {
        self.finder.bytes_skipped
    }

    fn heartbeat(&mut self, frame: &Frame) -> Option<Order> {
        let heartbeat = message::<HEARTBEAT_DATA>(frame);
        // other vehicles' and components' heartbeats are no ground
        let commands = |of| matches!(of, MavType::MAV_TYPE_GCS | MavType::MAV_TYPE_ONBOARD_CONTROLLER);
        let from_ground = heartbeat.map(|data| commands(data.mavtype));
        self.counted(from_ground)?.then_some(Order::Heartbeat)
    }

    fn manual_control(&mut self, frame: &Frame) -> Option<Order> {
        let data = self.counted(message::<MANUAL_CONTROL_DATA>(frame))?;
        if !self.is_for_us(data.target) {
            return None;
        }
        // i16::MAX says that there is no such axis
        let in_range = |axis: i16| (-1000..=1000).contains(&axis);
        let valid = [data.x, data.y, data.z, data.r].into_iter().all(in_range);
        let share = |axis: i16| f32::from(axis) / 1000.0;
        self.counted(valid.then(|| {
            let throttle = limit(share(data.z), 0.0, 1.0);
            let sticks = Sticks { roll: share(data.y), pitch: -share(data.x), throttle, yaw: share(data.r) };
            Order::Fly(self.settings.curves.stabilise(&sticks))
        }))
    }

    /// Both kinds of command; a number that no dialect knows is answered, too.
    fn command(&mut self, frame: &Frame) -> Option<Order> {
        let byte = |at: usize| frame.payload.get(at).copied().unwrap_or_default();
        // number, system and component lie at the same place in both
        let ours = self.is_for_this_component(byte(30), byte(31));
        let number = u16::from_le_bytes([byte(28), byte(29)]);
        let as_long = as_command_long(frame);
        ours.then(|| message(&as_long).map_or(Order::UnknownCommand(number), |data| order_of(&data)))
    }

    fn attitude_target(&mut self, frame: &Frame) -> Option<Order> {
        // bits that the dialect does not know make the message unusable, as they may change what it means
        let data = self.counted(message::<SET_ATTITUDE_TARGET_DATA>(frame))?;
        if !self.is_for_this_component(data.target_system, data.target_component) {
            return None;
        }
        self.counted(offboard_setpoint(&data)).map(Order::FlyOffboard)
    }

    fn plan_length(&mut self, frame: &Frame) -> Option<Order> {
        let data = self.counted(message::<MISSION_REQUEST_LIST_DATA>(frame))?;
        // an extension of the message; a mission where it is left out
        let kind = frame.payload.get(2).copied().unwrap_or_default();
        let asker = [frame.system_id, frame.component_id];
        let ours = self.is_for_this_component(data.target_system, data.target_component);
        ours.then_some(Order::Inquire(Inquiry::PlanLength { kind, asker }))
    }

    fn timesync(&mut self, frame: &Frame) -> Option<Order> {
        let data = self.counted(message::<TIMESYNC_DATA>(frame))?;
        // any other is somebody's answer
        (data.tc1 == 0).then_some(Order::Inquire(Inquiry::Time { their_ns: data.ts1 }))
    }

    fn signing(&mut self, frame: &Frame) -> Option<Order> {
        let data = self.counted(message::<SETUP_SIGNING_DATA>(frame))?;
        if !self.is_for_this_component(data.target_system, data.target_component) {
            return None;
        }
        let first_timestamp = data.initial_timestamp;
        let setup = SigningSetup { key: Key::new(data.secret_key), first_timestamp, is_local: self.is_local };
        self.counted((first_timestamp <= FIRST_TIMESTAMP_MAX).then_some(Order::SetUpSigning(setup)))
    }

    fn parameters(&mut self, frame: &Frame) -> Option<ParameterRequest> {
        let (system_id, component_id, request) = match frame.message_id {
            PARAM_REQUEST_LIST_DATA::ID => {
                let data = self.counted(message::<PARAM_REQUEST_LIST_DATA>(frame))?;
                (data.target_system, data.target_component, ParameterRequest::List)
            }
            PARAM_REQUEST_READ_DATA::ID => {
                let data = self.counted(message::<PARAM_REQUEST_READ_DATA>(frame))?;
                (data.target_system, data.target_component, read_request(&data))
            }
            PARAM_SET_DATA::ID => {
                let data = self.counted(message::<PARAM_SET_DATA>(frame))?;
                (data.target_system, data.target_component, set_request(&data))
            }
            _ => return None,
        };
        self.is_for_this_component(system_id, component_id).then_some(request)
    }

    fn logs(&mut self, frame: &Frame) -> Option<Order> {
        let ([system_id, component_id], request) = self.counted(log_download::request_of(frame))?;
        self.is_for_this_component(system_id, component_id).then_some(Order::Logs(request))
    }

    fn is_for_us(&self, system_id: u8) -> bool {
        system_id == 0 || system_id == self.settings.system_id
    }

    fn is_for_this_component(&self, system_id: u8, component_id: u8) -> bool {
        self.is_for_us(system_id) && (component_id == 0 || component_id == COMPONENT_ID)
    }

    fn counted<T>(&mut self, sense: Option<T>) -> Option<T> {
        if sense.is_none() {
            self.rejected = self.rejected.saturating_add(1);
        }
        sense
    }
}

fn order_of(data: &COMMAND_LONG_DATA) -> Order {
    let wrong = Order::Senseless(data.command);
    match data.command {
        MavCmd::MAV_CMD_COMPONENT_ARM_DISARM if data.param1 == 1.0 => Order::Arm,
        MavCmd::MAV_CMD_COMPONENT_ARM_DISARM if data.param1 == 0.0 && data.param2 == BY_FORCE => {
            Order::Stop(data.command)
        }
        MavCmd::MAV_CMD_COMPONENT_ARM_DISARM if data.param1 == 0.0 => Order::Disarm,
        MavCmd::MAV_CMD_COMPONENT_ARM_DISARM => wrong,
        MavCmd::MAV_CMD_MISSION_START => Order::StartTestSequence,
        MavCmd::MAV_CMD_DO_MOTOR_TEST => motor_test(data).map_or(wrong, Order::TestMotor),
        MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION if calibrates(data, [0.0, 1.0]) => Order::CalibrateEscs,
        MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION if calibrates(data, [2.0, 0.0]) => Order::CalibrateLevel,
        MavCmd::MAV_CMD_PREFLIGHT_CALIBRATION => wrong,
        MavCmd::MAV_CMD_PREFLIGHT_STORAGE if data.param1 == 1.0 => Order::ConfirmConfiguration,
        MavCmd::MAV_CMD_PREFLIGHT_STORAGE => wrong,
        MavCmd::MAV_CMD_USER_1 => Order::FaultRecordRead,
        MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN if data.param1 == 1.0 => Order::Restart,
        MavCmd::MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN => wrong,
        MavCmd::MAV_CMD_DO_FLIGHTTERMINATION if data.param1 == 1.0 => Order::Stop(data.command),
        MavCmd::MAV_CMD_DO_FLIGHTTERMINATION => wrong,
        MavCmd::MAV_CMD_DO_SET_MODE => Mode::of_number(data.param2).map_or(wrong, Order::ChooseMode),
        MavCmd::MAV_CMD_REQUEST_MESSAGE
        | MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL
        | MavCmd::MAV_CMD_GET_MESSAGE_INTERVAL => inquiry(data).map_or(wrong, Order::Inquire),
        // what older ground stations still send; superseded by the request for the message
        command if command as u16 == REQUEST_AUTOPILOT_CAPABILITIES => {
            Order::Inquire(Inquiry::Message { message_id: AUTOPILOT_VERSION_DATA::ID, index: 0, command })
        }
        command => Order::UnknownCommand(command as u16),
    }
}

/// What one of the commands about messages wants to know.
fn inquiry(data: &COMMAND_LONG_DATA) -> Option<Inquiry> {
    // `as` truncates and saturates, and makes 0 of what is no number
    let message_id = data.param1 as u32;
    (message_id as f32 == data.param1 && message_id < 1 << 24).then_some(match data.command {
        MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL => Inquiry::Interval { message_id, interval_us: data.param2 },
        MavCmd::MAV_CMD_GET_MESSAGE_INTERVAL => Inquiry::TellInterval { message_id },
        command => Inquiry::Message { message_id, index: data.param2 as u32, command },
    })
}

/// A `COMMAND_INT` with its two whole numbers as parameters 5 and 6, where a `COMMAND_LONG` has them; others as they
/// are. What is not given (`i32::MAX`) becomes no number.
fn as_command_long(frame: &Frame) -> Frame {
    let mut long = frame.clone();
    if frame.message_id == COMMAND_INT_DATA::ID {
        long.message_id = COMMAND_LONG_DATA::ID;
        for at in [16, 20] {
            let Some(bytes) = long.payload.get_mut(at..at + 4) else { continue };
            let whole = bytes.iter().rev().fold(0u32, |number, byte| number << 8 | u32::from(*byte)) as i32;
            let number = if whole == i32::MAX { f32::NAN } else { whole as f32 };
            bytes.copy_from_slice(&number.to_le_bytes());
        }
    }
    long
}

/// What a companion computer wants: an attitude, or rates about the body's axes. Of the attitude's heading nothing is
/// flown, but its rate, where that is given.
fn offboard_setpoint(data: &SET_ATTITUDE_TARGET_DATA) -> Option<Setpoint> {
    use AttitudeTargetTypemask as Ignored;
    let ignores = |bits: Ignored| data.type_mask.intersects(bits);
    let rate = |rate_rad_s: f32, ignored: Ignored| if ignores(ignored) { 0.0 } else { rate_rad_s };
    let no_throttle =
        Ignored::ATTITUDE_TARGET_TYPEMASK_THROTTLE_IGNORE | Ignored::ATTITUDE_TARGET_TYPEMASK_THRUST_BODY_SET;
    if ignores(no_throttle) || !(0.0..=1.0).contains(&data.thrust) {
        return None;
    }
    let yaw_rate_rad_s = rate(data.body_yaw_rate, Ignored::ATTITUDE_TARGET_TYPEMASK_BODY_YAW_RATE_IGNORE);
    let level = Setpoint { throttle: data.thrust, yaw_rate_rad_s, ..Setpoint::default() };
    let setpoint = if ignores(Ignored::ATTITUDE_TARGET_TYPEMASK_ATTITUDE_IGNORE) {
        let roll = rate(data.body_roll_rate, Ignored::ATTITUDE_TARGET_TYPEMASK_BODY_ROLL_RATE_IGNORE);
        let pitch = rate(data.body_pitch_rate, Ignored::ATTITUDE_TARGET_TYPEMASK_BODY_PITCH_RATE_IGNORE);
        Setpoint { acro_rad_s: Some([roll, pitch, yaw_rate_rad_s]), ..level }
    } else {
        let [w, x, y, z] = data.q;
        if !(0.9..=1.1).contains(&(w * w + x * x + y * y + z * z)) {
            return None;
        }
        let angles = euler_from_q(&normalized(Quaternion::new(w, x, y, z)));
        Setpoint { roll_rad: angles.roll_rad, pitch_rad: angles.pitch_rad, ..level }
    };
    let tilts = [setpoint.roll_rad, setpoint.pitch_rad];
    let upright = tilts.iter().all(|tilt_rad| (-OFFBOARD_TILT_MAX_RAD..=OFFBOARD_TILT_MAX_RAD).contains(tilt_rad));
    (setpoint.is_finite() && upright).then_some(setpoint)
}

/// One motor (param5 0 or 1), throttle in percent (param2 0); the supervisor limits throttle and time.
fn motor_test(data: &COMMAND_LONG_DATA) -> Option<MotorTest> {
    let whole_motor = data.param1 >= 1.0 && data.param1 <= 255.0 && data.param1 == f32::from(data.param1 as u8);
    let one_motor = data.param5 == 0.0 || data.param5 == 1.0;
    let sensible = (0.0..=100.0).contains(&data.param3) && (0.0..=3600.0).contains(&data.param4);
    (whole_motor && one_motor && data.param2 == 0.0 && sensible).then_some(MotorTest {
        motor: data.param1 as u8,
        throttle_percent: data.param3 as u8,
        // `as` saturates
        duration_ms: (data.param4 * 1000.0) as u16,
    })
}

/// The level (param5 2) or the ESCs (param7 1), and nothing else.
fn calibrates(data: &COMMAND_LONG_DATA, what: [f32; 2]) -> bool {
    let others = [data.param1, data.param2, data.param3, data.param4, data.param6];
    [data.param5, data.param7] == what && others.iter().all(|param| *param == 0.0)
}

/// What a `PARAM_REQUEST_READ` requests: by index, or by name if the index is negative.
fn read_request(data: &PARAM_REQUEST_READ_DATA) -> ParameterRequest {
    let field = match usize::try_from(data.param_index) {
        Ok(index) => Field::by_index(index),
        Err(_) => named(&*data.param_id),
    };
    field.map_or(ParameterRequest::Unknown, ParameterRequest::Read)
}

/// What a `PARAM_SET` requests.
fn set_request(data: &PARAM_SET_DATA) -> ParameterRequest {
    let is_real = data.param_type == MavParamType::MAV_PARAM_TYPE_REAL32;
    let value = if is_real { data.param_value } else { f32::NAN };
    named(&*data.param_id).map_or(ParameterRequest::Unknown, |field| ParameterRequest::Set { field, value })
}

/// The field whose name stands before the first zero.
#[inline(never)] // twice in the receiver it costs 200 bytes of flash
fn named(id: &[u8]) -> Option<Field> {
    Field::by_name(id.split(|byte| *byte == 0).next().unwrap_or_default())
}

/// Last byte of the CRC of the messages that are understood.
fn crc_extra(message_id: u32) -> Option<u8> {
    match message_id {
        HEARTBEAT_DATA::ID => Some(HEARTBEAT_DATA::EXTRA_CRC),
        MANUAL_CONTROL_DATA::ID => Some(MANUAL_CONTROL_DATA::EXTRA_CRC),
        COMMAND_LONG_DATA::ID => Some(COMMAND_LONG_DATA::EXTRA_CRC),
        COMMAND_INT_DATA::ID => Some(COMMAND_INT_DATA::EXTRA_CRC),
        SET_ATTITUDE_TARGET_DATA::ID => Some(SET_ATTITUDE_TARGET_DATA::EXTRA_CRC),
        MISSION_REQUEST_LIST_DATA::ID => Some(MISSION_REQUEST_LIST_DATA::EXTRA_CRC),
        TIMESYNC_DATA::ID => Some(TIMESYNC_DATA::EXTRA_CRC),
        HIL_SENSOR_DATA::ID => Some(HIL_SENSOR_DATA::EXTRA_CRC),
        PARAM_REQUEST_LIST_DATA::ID => Some(PARAM_REQUEST_LIST_DATA::EXTRA_CRC),
        PARAM_REQUEST_READ_DATA::ID => Some(PARAM_REQUEST_READ_DATA::EXTRA_CRC),
        PARAM_SET_DATA::ID => Some(PARAM_SET_DATA::EXTRA_CRC),
        SETUP_SIGNING_DATA::ID => Some(SETUP_SIGNING_DATA::EXTRA_CRC),
        FILE_TRANSFER_PROTOCOL_DATA::ID => Some(FILE_TRANSFER_PROTOCOL_DATA::EXTRA_CRC),
        _ => log_download::crc_extra(message_id),
    }
}

#[cfg(test)]
mod tests;
