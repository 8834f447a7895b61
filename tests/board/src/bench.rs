//! What somebody at the bench does with the board: its supply, its connectors, its memory chip, its faults.

use shared_control::params::{self, Params};

use crate::board::serial::Connector;
use crate::devices::io_chip::{CHANNELS, IoChip, IoFault, IoFirmware};
use crate::devices::mpu6000::Mpu6000Revision;
use crate::devices::mpu6000_start::START_UP;
use crate::devices::sd_card::SdCard;
use crate::devices::usb_host::UsbHost;
use crate::devices::{Sensor, SensorFault};
use crate::machine::Machine;
use crate::peripherals::line_noise::LineNoise;
use crate::peripherals::pin::Load;
use crate::rules::Broken;
use crate::time::Ticks;

impl Machine {
    /// Sends on TELEM1's line.
    pub fn telem1_send(&mut self, bytes: &[u8]) {
        self.line_send(Connector::Telem1, bytes);
    }

    /// What came out of TELEM1 since the last call.
    pub fn telem1_receive(&mut self) -> Vec<u8> {
        self.line_receive(Connector::Telem1)
    }

    /// Any bytes on TELEM1's line, one after the other without a gap, until switched off.
    pub fn telem1_flood(&mut self, on: bool) {
        let mut board = self.board.borrow_mut();
        let now = board.now;
        board.usart(Connector::Telem1).flood(on, now);
    }

    /// Sends on a connector's line, if the image listens to it.
    pub fn line_send(&mut self, connector: Connector, bytes: &[u8]) {
        self.board.borrow_mut().line_sends(connector, bytes);
    }

    /// What came out of a connector since the last call.
    pub fn line_receive(&mut self, connector: Connector) -> Vec<u8> {
        self.board.borrow_mut().line_received(connector)
    }

    /// The baud rate at a connector's far end from now on; 57600 at first.
    pub fn set_far_baud(&mut self, connector: Connector, baud: u64) {
        self.board.borrow_mut().usart(connector).set_far_baud(baud);
    }

    /// The chip's supply from now on, V.
    pub fn set_supply_v(&mut self, supply_v: f32) {
        self.board.borrow_mut().set_supply_v(supply_v);
    }

    /// Stops the crystal, for good; called before the first run it never starts.
    pub fn stop_crystal(&mut self) {
        self.board.borrow_mut().set_crystal(false);
    }

    /// Lets it oscillate again, whenever the image switches it on.
    pub fn mend_crystal(&mut self) {
        self.board.borrow_mut().set_crystal(true);
    }

    /// The battery's voltage from now on, V; 12.4 at first.
    pub fn set_battery_v(&mut self, battery_v: f32) {
        self.board.borrow_mut().set_battery_v(battery_v);
    }

    /// What the buzzer sounds at, Hz; none if it is silent.
    pub fn buzzer_hz(&self) -> Option<f64> {
        self.board.borrow().buzzer_hz()
    }

    /// Lets a sensor fail, from now on and over resets.
    pub fn break_sensor(&mut self, sensor: Sensor, fault: SensorFault) {
        self.board.borrow_mut().set_sensor_fault(sensor, Some(fault));
    }

    /// Makes it whole again.
    pub fn mend_sensor(&mut self, sensor: Sensor) {
        self.board.borrow_mut().set_sensor_fault(sensor, None);
    }

    /// Stores the owner's choices in the FRAM, as the firmware would; it reads them when it starts.
    pub fn configure(&mut self, params: &Params) {
        self.write_fram(0, &params::encode(params));
    }

    /// Makes the FRAM as it came from its maker.
    pub fn blank_fram(&mut self) {
        self.board.borrow_mut().fram.blank();
    }

    /// Puts bytes into the FRAM past its bus, damaged ones for instance.
    pub fn write_fram(&mut self, address: usize, bytes: &[u8]) {
        self.board.borrow_mut().fram.put(address, bytes);
    }

    /// Bytes that the FRAM holds.
    pub fn read_fram(&self, address: usize, length: usize) -> Vec<u8> {
        self.board.borrow().fram.content().iter().cycle().skip(address).take(length).copied().collect()
    }

    /// Puts a card into the slot, in the place of one that was there.
    pub fn insert_card(&mut self, mut card: SdCard) {
        card.power_up();
        self.board.borrow_mut().card = Some(card);
    }

    /// Does something to the card, if there is one, or looks at it.
    pub fn with_card<T>(&mut self, action: impl FnOnce(&mut SdCard) -> T) -> Option<T> {
        self.board.borrow_mut().card.as_mut().map(action)
    }

    /// Does something at the computer that USB leads to, or looks at it; nothing is plugged in at first.
    pub fn with_usb<T>(&mut self, action: impl FnOnce(&mut UsbHost) -> T) -> T {
        action(&mut self.board.borrow_mut().usb)
    }

    /// Does the board pull USB's D+ up, whether anything is plugged in or not?
    pub fn pulls_usb_up(&self) -> bool {
        self.board.borrow().otg_fs.is_attached()
    }

    /// These rules of the documents stop nothing when they are broken, all others do.
    pub fn tolerate(&mut self, rules: &[&'static str]) {
        self.board.borrow_mut().tolerate(rules);
    }

    /// Rules that were tolerated and broken so far.
    pub fn broken_rules(&self) -> Vec<Broken> {
        self.board.borrow().broken.clone()
    }

    /// The capacitance at the pins.
    pub fn set_load(&mut self, load: Load) {
        self.board.borrow_mut().set_load(load);
    }

    /// Since when each of the lines of AUX 4 to 1, TIM1's channels, is high at the ESC.
    pub fn aux_high_since(&mut self) -> [Option<Ticks>; 4] {
        self.board.borrow_mut().aux_high_since()
    }

    /// How long an AUX line stays low after its pin has let go, to be called before the first run.
    pub fn set_aux_floats_low(&mut self, duration: Ticks) {
        self.board.borrow_mut().set_aux_floats_low(duration);
    }

    /// Does the image run with flash prefetch?
    pub fn prefetches(&self) -> bool {
        self.board.borrow().flash_access().prefetches()
    }

    /// The chip's supply dips for so long.
    pub fn dip_supply(&mut self, supply_v: f32, duration: Ticks) {
        self.board.borrow_mut().dip_supply(supply_v, duration);
    }

    /// The rate of the chip's slow oscillator; 32 kHz at first.
    pub fn set_lsi_hz(&mut self, lsi_hz: u64) {
        self.board.borrow_mut().set_lsi_hz(lsi_hz);
    }

    /// The MPU6000 that is soldered in, and how often it will come up badly before it comes up well.
    pub fn set_mpu6000(&mut self, revision: Mpu6000Revision, bad_starts: u8) {
        let mut board = self.board.borrow_mut();
        board.mpu6000.set_revision(revision);
        board.mpu6000.start_mut().come_up_badly(bad_starts);
    }

    /// From power to its first answer: the typical chip's 11 ms or the slowest one's 100.
    pub fn set_mpu6000_start_up(&mut self, slowest: bool) {
        self.board.borrow_mut().mpu6000.start_mut().set_start_up(START_UP[usize::from(slowest)]);
    }

    /// The MPU6000 alone starts anew, by a dip of its supply: it has lost its settings and sleeps.
    pub fn restart_mpu6000(&mut self) {
        let mut board = self.board.borrow_mut();
        let now = board.now;
        board.mpu6000.lose_settings(now);
    }

    /// The second IMU's gyro alone starts anew.
    pub fn restart_l3gd20(&mut self) {
        let mut board = self.board.borrow_mut();
        let now = board.now;
        board.l3gd20.lose_settings(now);
    }

    /// The second IMU's accelerometer alone starts anew.
    pub fn restart_lsm303d(&mut self) {
        let mut board = self.board.borrow_mut();
        let now = board.now;
        board.lsm303d.lose_settings(now);
    }

    /// A register of the second IMU's gyro holds another value from now on; for good if it keeps nothing that is
    /// written.
    pub fn turn_l3gd20_register(&mut self, register: u8, value: u8, for_good: bool) {
        self.board.borrow_mut().l3gd20.turn_register(register, value, for_good);
    }

    /// The same of its accelerometer.
    pub fn turn_lsm303d_register(&mut self, register: u8, value: u8, for_good: bool) {
        self.board.borrow_mut().lsm303d.turn_register(register, value, for_good);
    }

    /// The FRAM sleeps, as another program may have left it; only its power or its select line wakes it.
    pub fn put_fram_to_sleep(&mut self) {
        self.board.borrow_mut().fram.fall_asleep();
    }

    /// A register of the MPU6000 holds another value from now on; for good if it keeps nothing that is written.
    pub fn turn_mpu6000_register(&mut self, register: u8, value: u8, for_good: bool) {
        self.board.borrow_mut().mpu6000.turn_register(register, value, for_good);
    }

    /// The FRAM's block protection: none, the upper quarter, the upper half, all of it (0 to 3).
    pub fn protect_fram(&mut self, blocks: u8) {
        self.board.borrow_mut().fram.protect(blocks);
    }

    /// The firmware in the IO chip, from now on; PX4's protocol 4 at first. The chip starts anew.
    pub fn set_io_firmware(&mut self, firmware: IoFirmware) {
        let mut board = self.board.borrow_mut();
        let now = board.now;
        board.io = IoChip::new(firmware, now);
    }

    /// The IO chip or its line fails from now on, or no longer.
    pub fn set_io_fault(&mut self, fault: Option<IoFault>) {
        self.board.borrow_mut().io.set_fault(fault);
    }

    /// The IO chip starts anew by itself.
    pub fn restart_io(&mut self) {
        let mut board = self.board.borrow_mut();
        let now = board.now;
        board.io.restart(now);
    }

    /// The IO chip is as an autopilot before left it: armed, safety off, MAIN driven.
    pub fn leave_io_armed(&mut self) {
        self.board.borrow_mut().io.leave_armed();
    }

    /// The receiver at the IO chip has heard a frame.
    pub fn radio_frame(&mut self, channels_us: &[u16; CHANNELS], failsafe: bool) {
        let mut board = self.board.borrow_mut();
        let now = board.now;
        board.io.radio_frame(channels_us, failsafe, now);
    }

    /// Somebody holds the safety button, or lets it go; what takes a second counts.
    pub fn press_safety_button(&mut self, pressed: bool) {
        let mut board = self.board.borrow_mut();
        let now = board.now;
        board.io.press(pressed, now);
    }

    /// Is safety off, as the button's light says?
    pub fn io_safety_is_off(&self) -> bool {
        self.board.borrow().io.is_safety_off()
    }

    /// Since the FMU started: is the chip known to it, disarmed and safe?
    pub fn io_is_made_safe(&self) -> bool {
        self.board.borrow().io.is_made_safe()
    }

    /// Pulses on MAIN, us; 0 is none.
    pub fn main_outputs_us(&self) -> [u16; 8] {
        let board = self.board.borrow();
        board.io.main_outputs_us(board.now)
    }

    /// The line towards TELEM1 loses and damages so many bytes of a thousand; 0 and 0 for none.
    pub fn telem1_noise(&mut self, lost_permille: u32, turned_permille: u32) {
        let noise = LineNoise::new(lost_permille, turned_permille, 1);
        self.board.borrow_mut().usart(Connector::Telem1).set_noise(Some(noise));
    }
}
