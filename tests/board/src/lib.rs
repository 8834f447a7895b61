//! A Pixhawk 1 that executes the firmware's own ELF, instruction by instruction, against the simulated vehicle.
//!
//! [`Machine`] is the board: a Cortex-M4F (the emulator unicorn executes its instructions), its exceptions, the
//! STM32F427's peripherals and the sensors around it. A [`World`] is what the sensors measure and the motor outputs
//! drive. README.md lists what is modelled, what is simplified, and what is not there.

mod bench;
mod board;
mod cortex;
mod cpu;
mod delays;
mod devices;
mod entry;
mod flight;
mod ground;
mod image;
mod machine;
mod memory;
mod peripherals;
pub mod pilot;
mod profile;
mod pulses;
pub mod rules;
mod seat;
mod second_imu;
mod standing;
mod stop;
pub mod thumb;
pub mod time;
mod trace;
mod translation;
mod transmitter;
mod twin;
mod vehicle;
mod world;

pub use board::serial::Connector;
pub use delays::Delays;
pub use devices::esc::{Esc, Mode as EscMode, Traits as EscTraits};
pub use devices::io_chip::{CHANNELS, IoFault, IoFirmware};
pub use devices::mpu6000::Mpu6000Revision;
pub use devices::sd_card::{CardFault, Content, Pauses, SECTOR_BYTES, SdCard, Sector};
pub use devices::usb_host::{Enumerated, Failure as UsbFailure, Request as UsbRequest, UsbHost};
pub use devices::{Counts, SecondGyro, Sensor, SensorFault};
pub use entry::EntryState;
pub use flight::{Flight, LOOK, MILLISECOND, ROTOR_DRAG_1_S};
pub use ground::Ground;
pub use image::{Image, ImageError};
pub use machine::{Counters, Machine};
pub use peripherals::iwdg::LSI_RANGE_HZ;
pub use peripherals::pin::Load;
pub use peripherals::timer::Pulse;
pub use profile::Profile;
pub use pulses::Pulses;
pub use seat::Seat;
pub use standing::TouchDown;
pub use stop::{Cause, Stop};
pub use trace::step_trace;
pub use transmitter::{FRAME_PERIOD, Transmitter};
pub use twin::{Planned, Twin};
pub use vehicle::{Surroundings, Vehicle};
pub use world::World;
