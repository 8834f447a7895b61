//! Descriptors. USB 2.0 section 9.6, CDC 1.2 section 5.2, interface association: USB ECN of 2003.

/// Vendor and product: pid.codes' number for tests. It may be used by whoever builds this for themselves; whoever
/// passes boards on needs a product number of their own (<https://pid.codes/howto>, free for open source). No number
/// of an autopilot's maker is used, since none was given to this project: so QGroundControl does not connect by itself.
pub const VENDOR_PRODUCT: [u16; 2] = [0x1209, 0x0001];
/// Who made it.
pub const MANUFACTURER: &str = "attitude control";
/// What it is. Not what PX4's boards are called, for the same reason.
pub const PRODUCT: &str = "Quadrotor on Pixhawk 1";
/// Binary-coded decimal: the device's release.
const RELEASE: u16 = 0x0001;

/// Bytes of a packet of endpoint 0, and of the endpoints for bytes: the most at full speed.
pub const PACKET_BYTES: usize = 64;
/// The endpoint for bytes, in both directions.
pub const DATA_ENDPOINT: u8 = 1;
/// The endpoint for notifications, towards the host; this device sends none.
pub const NOTICE_ENDPOINT: u8 = 2;
/// Bytes of its packets: one notification of the line's state fits.
pub const NOTICE_BYTES: usize = 16;
/// The interface that requests of the class go to.
pub const CONTROL_INTERFACE: u8 = 0;
/// The interface of the bytes.
pub const DATA_INTERFACE: u8 = 1;
/// The one configuration's number.
pub const CONFIGURATION_VALUE: u8 = 1;

/// Descriptor types.
pub(super) const DEVICE_TYPE: u8 = 1;
pub(super) const CONFIGURATION_TYPE: u8 = 2;
pub(super) const STRING_TYPE: u8 = 3;
const INTERFACE_TYPE: u8 = 4;
const ENDPOINT_TYPE: u8 = 5;
const ASSOCIATION_TYPE: u8 = 11;
const CLASS_INTERFACE: u8 = 0x24;

const TO_HOST: u8 = 0x80;
const BULK: u8 = 2;
const INTERRUPT: u8 = 3;
/// Communications class, abstract control model, no protocol.
const CDC: [u8; 3] = [2, 2, 0];
const CDC_DATA: [u8; 3] = [0x0a, 0, 0];

const fn low(number: u16) -> u8 {
    number.to_le_bytes()[0]
}

const fn high(number: u16) -> u8 {
    number.to_le_bytes()[1]
}

/// The device descriptor: USB 2.0, a device of several interfaces that belong together.
#[rustfmt::skip]
pub const DEVICE: [u8; 18] = [
    18, DEVICE_TYPE, 0x00, 0x02, 0xef, 0x02, 0x01, PACKET_BYTES as u8,
    low(VENDOR_PRODUCT[0]), high(VENDOR_PRODUCT[0]), low(VENDOR_PRODUCT[1]), high(VENDOR_PRODUCT[1]),
    low(RELEASE), high(RELEASE), 1, 2, 3, 1,
];

/// Length of the configuration with all that belongs to it.
const CONFIGURATION_LEN: usize = 9 + 8 + 9 + 5 + 5 + 4 + 5 + 7 + 9 + 7 + 7;

/// The configuration: fed by the bus with at most 500 mA, as long as there is no battery.
#[rustfmt::skip]
pub const CONFIGURATION: [u8; CONFIGURATION_LEN] = [
    9, CONFIGURATION_TYPE, CONFIGURATION_LEN as u8, 0, 2, CONFIGURATION_VALUE, 0, 0x80, 250,
    8, ASSOCIATION_TYPE, CONTROL_INTERFACE, 2, CDC[0], CDC[1], CDC[2], 0,
    9, INTERFACE_TYPE, CONTROL_INTERFACE, 0, 1, CDC[0], CDC[1], CDC[2], 0,
    // header: CDC 1.10; call management: none
    5, CLASS_INTERFACE, 0x00, 0x10, 0x01,
    5, CLASS_INTERFACE, 0x01, 0x00, DATA_INTERFACE,
    // abstract control: line coding and state
    4, CLASS_INTERFACE, 0x02, 0x02,
    // union of both interfaces
    5, CLASS_INTERFACE, 0x06, CONTROL_INTERFACE, DATA_INTERFACE,
    // every 255 ms: there is nothing to fetch
    7, ENDPOINT_TYPE, TO_HOST | NOTICE_ENDPOINT, INTERRUPT, NOTICE_BYTES as u8, 0, 255,
    9, INTERFACE_TYPE, DATA_INTERFACE, 0, 2, CDC_DATA[0], CDC_DATA[1], CDC_DATA[2], 0,
    7, ENDPOINT_TYPE, DATA_ENDPOINT, BULK, PACKET_BYTES as u8, 0, 0,
    7, ENDPOINT_TYPE, TO_HOST | DATA_ENDPOINT, BULK, PACKET_BYTES as u8, 0, 0,
];

/// String 0: American English.
pub const LANGUAGES: [u8; 4] = [4, STRING_TYPE, 0x09, 0x04];
