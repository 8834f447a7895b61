//! From bytes to orders: what the ground wants, checked for address and sense.

use mavlink::MessageData;
use mavlink::dialects::common::{
    COMMAND_LONG_DATA, HEARTBEAT_DATA, HIL_SENSOR_DATA, MANUAL_CONTROL_DATA, MavCmd, MavParamType, MavType,
    PARAM_REQUEST_LIST_DATA, PARAM_REQUEST_READ_DATA, PARAM_SET_DATA,
};

use super::frame::{Frame, FrameFinder, message};
use super::hil::HilTick;
use super::orders_and_answers::{Order, ParameterRequest};
use super::settings::{COMPONENT_ID, LinkSettings};
use crate::elementary::limit;
use crate::params::table::Field;
use crate::radio::Sticks;
use crate::signals::MotorTest;

/// Turns the bytes that arrive into orders.
#[derive(Clone, Debug)]
pub struct Receiver {
    settings: LinkSettings,
    finder: FrameFinder,
    /// Frames with a right CRC and a content that makes no sense: values that don't exist, NaN, invalid axes.
    pub rejected: u32,
}

impl Receiver {
    /// A receiver that has heard nothing.
    pub fn new(settings: LinkSettings) -> Self {
        Self { settings, finder: FrameFinder::default(), rejected: 0 }
    }

    /// Takes one byte.
    pub fn receive(&mut self, byte: u8) -> Option<Order> {
        let frame = self.finder.push(byte, crc_extra)?;
        match frame.message_id {
            HEARTBEAT_DATA::ID => self.heartbeat(&frame),
            MANUAL_CONTROL_DATA::ID => self.manual_control(&frame),
            COMMAND_LONG_DATA::ID => self.command_long(&frame),
            HIL_SENSOR_DATA::ID => {
                let tick = self.counted(message::<HIL_SENSOR_DATA>(&frame).map(|data| HilTick::new(&data)))?;
                // a tick without a sample makes its step, and counts
                self.counted(tick.imu);
                Some(Order::HilTick(tick))
            }
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
        let from_ground = heartbeat.map(|data| data.mavtype == MavType::MAV_TYPE_GCS);
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

    fn command_long(&mut self, frame: &Frame) -> Option<Order> {
        let data = self.counted(message::<COMMAND_LONG_DATA>(frame))?;
        self.is_for_this_component(data.target_system, data.target_component).then(|| order_of(&data))
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
    let wrong = Order::NotUnderstood { command: data.command, known: true };
    match data.command {
        MavCmd::MAV_CMD_COMPONENT_ARM_DISARM if data.param1 == 1.0 => Order::Arm,
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
        command => Order::NotUnderstood { command, known: false },
    }
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
        HIL_SENSOR_DATA::ID => Some(HIL_SENSOR_DATA::EXTRA_CRC),
        PARAM_REQUEST_LIST_DATA::ID => Some(PARAM_REQUEST_LIST_DATA::EXTRA_CRC),
        PARAM_REQUEST_READ_DATA::ID => Some(PARAM_REQUEST_READ_DATA::EXTRA_CRC),
        PARAM_SET_DATA::ID => Some(PARAM_SET_DATA::EXTRA_CRC),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
