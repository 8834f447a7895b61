//! The board as a block diagram: the chip's peripherals, the devices around it, and the wires between them.
//!
//! ```text
//!  PE3 --------> sensors <--- world: counts at each one's sample clock
//!  PC2, 13, 15 -> select      `--- data-ready --> PD15, PB0, PB4 -> SYSCFG -> EXTI -> NVIC
//!  SPI1 <------> sensors      DMA2 S0 <-- received    S5 --> to send
//!  SPI2 <------> FRAM (PD10)
//!  TIM3 -- trigger output (update) --> TIM1 --> PE14, 13, 11, 9 --> world: pulses
//!  USART2 <----> TELEM1       DMA1 S5 <-- received    S6 --> to send
//!  USART3 <----> TELEM2       DMA1 S1 <-- received    S3, S4 --> to send
//!  USART6 <----> IO chip      DMA2 S1, S2 <-- received    S6, S7 --> to send
//!  PA2 (battery) -> ADC1      DMA2 S4 <-- conversions
//!  SDIO <-------> SD card     DMA2 S3, S6 <-> blocks
//!  OTG_FS <-----> computer    PA9, PC0 <-- is there 5 V at its connector?
//!  PA15 (buzzer) <- TIM2      TIM5: time base      RCC: clocks of all of them
//! ```
//!
//! `address_map` is what the core sees of it, `buses` who answers on SPI1 and SPI2, `sensors` their clocks and faults,
//! `electrics` what lies between pins and parts, `analog` battery and buzzer, `serial` the connectors, `io_chip` the
//! second processor, `card_slot` the SD card, `usb_socket` USB, `wiring` DMA requests and interrupt lines.

mod address_map;
mod analog;
mod buses;
mod card_slot;
mod electrics;
mod io_chip;
mod sensors;
pub(crate) mod serial;
mod usb_socket;
mod wiring;

use analog::USUAL_BATTERY_V;
use serial::USUAL_BAUD;

use crate::cortex::private_bus::PrivateBus;
use crate::devices::aux_line::AuxLine;
use crate::devices::fram::Fram;
use crate::devices::io_chip::{self as io, IoChip, IoFirmware};
use crate::devices::l3gd20::{L3GD20, L3GD20H};
use crate::devices::level_shifter::FLOATS_LOW;
use crate::devices::lsm303d::LSM303D;
use crate::devices::mpu6000::Mpu6000;
use crate::devices::sd_card::SdCard;
use crate::devices::sensor_rail::{CAPACITANCE_UF, SensorRail};
use crate::devices::st_sensor::StSensor;
use crate::devices::usb_host::UsbHost;
use crate::devices::{SecondGyro, SensorFault};
use crate::memory::{self, Memory};
use crate::peripherals::Peripheral;
use crate::peripherals::adc::Adc;
use crate::peripherals::dbgmcu::DbgMcu;
use crate::peripherals::dma::Dma;
use crate::peripherals::exti::Exti;
use crate::peripherals::flash::Flash;
use crate::peripherals::flash_timing::AccessControl;
use crate::peripherals::gpio::Gpio;
use crate::peripherals::iwdg::{Iwdg, LSI_HZ};
use crate::peripherals::otg_fs::OtgFs;
use crate::peripherals::pin::Load;
use crate::peripherals::pwr::Pwr;
use crate::peripherals::rcc::{Clocks, Rcc};
use crate::peripherals::sdio::Sdio;
use crate::peripherals::spi::Spi;
use crate::peripherals::syscfg::SysCfg;
use crate::peripherals::timer::Timer;
use crate::peripherals::usart::Usart;
use crate::rules::Broken;
use crate::stop::{Cause, Stop};
use crate::time::Ticks;
use crate::world::{Nowhere, World};

const PORTS: [char; 9] = ['A', 'B', 'C', 'D', 'E', 'F', 'G', 'H', 'I'];
const A: usize = 0;
const B: usize = 1;
const C: usize = 2;
const D: usize = 3;
const E: usize = 4;
/// What is read of a data line that nobody drives.
const FLOATING: u8 = 0xff;
/// Reset flags of power-on, brown-out and pin (section 6.3.21).
const POWER_ON: u32 = 1 << 27 | 1 << 26 | 1 << 25;
const USUAL_SUPPLY_V: f32 = 3.3;

/// All that is not the core or its memory. A copy is the same in all but its world: it has none.
#[derive(Clone)]
pub(crate) struct Board {
    pub(crate) private: PrivateBus,
    rcc: Rcc,
    clocks: Clocks,
    pwr: Pwr,
    flash: Flash,
    ports: [Gpio; PORTS.len()],
    exti: Exti,
    syscfg: SysCfg,
    dma: [Dma; 2],
    spi1: Spi,
    spi2: Spi,
    adc1: Adc,
    tim1: Timer,
    tim2: Timer,
    tim3: Timer,
    tim5: Timer,
    usart2: Usart,
    usart3: Usart,
    usart6: Usart,
    sdio: Sdio,
    /// In the slot, or it was.
    pub(crate) card: Option<SdCard>,
    pub(crate) io: IoChip,
    pub(crate) otg_fs: OtgFs,
    /// At the USB connector.
    pub(crate) usb: UsbHost,
    iwdg: Iwdg,
    dbgmcu: DbgMcu,
    backup_ram: Vec<u8>,
    pub(crate) mpu6000: Mpu6000,
    pub(crate) l3gd20: StSensor,
    pub(crate) lsm303d: StSensor,
    sensor_faults: [Option<SensorFault>; 3],
    pub(crate) fram: Fram,
    aux: [AuxLine; 4],
    aux_floats_low: Ticks,
    rail: SensorRail,
    /// Is the sensors' supply on, and how many lines are driven high into them?
    rail_state: (bool, u32),
    load: Load,
    /// What SPI1 and SPI2 received last.
    last_answer: [u8; 2],
    clock_floated: bool,
    /// The supply comes back to this voltage then.
    dip_end: Option<(Ticks, f32)>,
    tolerated: Vec<&'static str>,
    pub(crate) broken: Vec<Broken>,
    battery_v: f32,
    pub(crate) world: Box<dyn World>,
    /// Time and core cycles at the start of the slice.
    pub(crate) now: Ticks,
    pub(crate) cycles: u64,
    pub(crate) stop: Option<Stop>,
}

impl Board {
    /// As after power-on.
    pub(crate) fn new(world: Box<dyn World>, seed: u64) -> Self {
        let rcc = Rcc::new(POWER_ON, true);
        let clocks = Clocks { core: 21, apb1: 21, apb2: 21, apb1_timers: 21, apb2_timers: 21, pll48: None };
        let gyro = if world.second_gyro() == Some(SecondGyro::L3gd20h) { &L3GD20H } else { &L3GD20 };
        let second_imu = world.second_gyro().is_none().then_some(SensorFault::Removed(FLOATING));
        let mut board = Self {
            private: PrivateBus::new(0),
            rcc,
            clocks,
            pwr: Pwr::new(USUAL_SUPPLY_V),
            flash: Flash::default(),
            ports: PORTS.map(Gpio::new),
            exti: Exti::default(),
            syscfg: SysCfg::default(),
            dma: Default::default(),
            spi1: Spi::default(),
            spi2: Spi::default(),
            adc1: Adc::default(),
            tim1: Timer::advanced(),
            tim2: Timer::general(u32::MAX),
            tim3: Timer::general(0xffff),
            tim5: Timer::general(u32::MAX),
            usart2: Usart::new(USUAL_BAUD),
            usart3: Usart::new(USUAL_BAUD),
            usart6: Usart::new(io::BAUD),
            sdio: Sdio::default(),
            card: None,
            io: IoChip::new(IoFirmware::Px4V4, 0),
            otg_fs: OtgFs::default(),
            usb: UsbHost::default(),
            iwdg: Iwdg::new(LSI_HZ),
            dbgmcu: DbgMcu::default(),
            backup_ram: memory::noise(0x1000, seed ^ 0xbac),
            mpu6000: Mpu6000::default(),
            l3gd20: StSensor::new(gyro),
            lsm303d: StSensor::new(&LSM303D),
            sensor_faults: [None, second_imu, second_imu],
            fram: Fram::default(),
            aux: std::array::from_fn(|_| AuxLine::new(0, FLOATS_LOW)),
            aux_floats_low: FLOATS_LOW,
            rail: SensorRail::new(CAPACITANCE_UF[1]),
            rail_state: (false, 0),
            load: Load::default(),
            last_answer: [FLOATING; 2],
            clock_floated: false,
            dip_end: None,
            tolerated: Vec::new(),
            broken: Vec::new(),
            battery_v: USUAL_BATTERY_V,
            world,
            now: 0,
            cycles: 0,
            stop: None,
        };
        board.distribute_clocks();
        board
    }

    /// A reset for these reasons (flags of RCC_CSR): what keeps its power stays, backup SRAM and the sensors.
    pub(crate) fn reset(&mut self, flags: u32) {
        self.tim1.cut_pulses(self.now);
        self.pass_on_pulses();
        // a card stays as it is, in the middle of a transfer perhaps
        let card = self.card.take();
        let mut fresh = self.without_power(0);
        fresh.card = card;
        std::mem::swap(&mut fresh.backup_ram, &mut self.backup_ram);
        std::mem::swap(&mut fresh.mpu6000, &mut self.mpu6000);
        std::mem::swap(&mut fresh.l3gd20, &mut self.l3gd20);
        std::mem::swap(&mut fresh.lsm303d, &mut self.lsm303d);
        std::mem::swap(&mut fresh.aux, &mut self.aux);
        std::mem::swap(&mut fresh.rail, &mut self.rail);
        std::mem::swap(&mut fresh.pwr, &mut self.pwr);
        std::mem::swap(&mut fresh.io, &mut self.io);
        fresh.io.fmu_restarted();
        fresh.pwr.reset();
        (fresh.rail_state, fresh.dip_end) = (self.rail_state, self.dip_end);
        fresh.rcc = Rcc::new(self.rcc.reset_flags() | flags, self.rcc.crystal_oscillates());
        *self = fresh;
        // the pins let go
        self.refresh_lines(self.now);
    }

    /// All power is gone and comes back. With a battery in its place the backup domain keeps its own, and backup SRAM
    /// if the regulator was on.
    pub(crate) fn power_cycle(&mut self, seed: u64, battery: bool) {
        self.tim1.cut_pulses(self.now);
        self.pass_on_pulses();
        let kept = battery && self.pwr.backup_regulator_on();
        let mut fresh = self.without_power(seed);
        if kept {
            std::mem::swap(&mut fresh.backup_ram, &mut self.backup_ram);
            std::mem::swap(&mut fresh.pwr, &mut self.pwr);
            fresh.pwr.reset();
        }
        *self = fresh;
    }

    /// The same board after it lost its power: what does not need any, and what is around it, is as it was.
    fn without_power(&mut self, seed: u64) -> Self {
        let mut fresh = Self::new(std::mem::replace(&mut self.world, Box::new(Nowhere)), seed);
        std::mem::swap(&mut fresh.fram, &mut self.fram);
        std::mem::swap(&mut fresh.broken, &mut self.broken);
        std::mem::swap(&mut fresh.tolerated, &mut self.tolerated);
        fresh.fram.power_up(self.now);
        fresh.card = self.card.take();
        if let Some(card) = &mut fresh.card {
            card.power_up();
        }
        fresh.load = self.load;
        fresh.rail = SensorRail::new(CAPACITANCE_UF[1]);
        fresh.aux_floats_low = self.aux_floats_low;
        fresh.aux = std::array::from_fn(|_| AuxLine::new(self.now, self.aux_floats_low));
        fresh.iwdg = Iwdg::new(self.iwdg.lsi_hz());
        std::mem::swap(&mut fresh.usart2, &mut self.usart2);
        std::mem::swap(&mut fresh.usart3, &mut self.usart3);
        std::mem::swap(&mut fresh.usart6, &mut self.usart6);
        fresh.usart2.reset();
        fresh.usart3.reset();
        fresh.usart6.reset();
        fresh.io = self.io.clone();
        fresh.usb = std::mem::take(&mut self.usb);
        fresh.io.restart(self.now);
        fresh.sensor_faults = self.sensor_faults;
        fresh.battery_v = self.battery_v;
        fresh.pwr = Pwr::new(self.pwr.supply_v());
        fresh.rcc.set_crystal(self.rcc.crystal_oscillates());
        (fresh.now, fresh.cycles) = (self.now, self.cycles);
        fresh
    }

    /// The reset that is due, by its flags in RCC_CSR (section 6.3.21); each pulls the reset pin too.
    pub(crate) fn due_reset(&self, now: Ticks) -> Option<u32> {
        const PIN: u32 = 1 << 26;
        if self.iwdg.bites(now) {
            return Some(PIN | 1 << 29);
        }
        self.private.reset_requested.then_some(PIN | 1 << 28)
    }

    /// Wait states and caches of flash.
    pub(crate) fn flash_access(&self) -> AccessControl {
        self.flash.access_control()
    }

    pub(crate) fn core_ticks(&self) -> Ticks {
        self.clocks.core
    }

    /// Everything that is due by `now`, in the order of the wires.
    pub(crate) fn tick(&mut self, now: Ticks, memory: &mut dyn Memory) {
        if self.private.systick.tick(now, self.clocks.core) {
            self.private.exceptions.pend(crate::cortex::exceptions::SYS_TICK);
        }
        if let Some((_, supply_v)) = self.dip_end.take_if(|(end, _)| *end <= now) {
            self.pwr.set_supply_v(supply_v);
        }
        self.tim2.tick(now);
        self.tim5.tick(now);
        self.tick_motor_timers(now);
        self.tick_sensors(now);
        self.tick_spi1(now, memory);
        self.tick_spi2(now);
        self.tick_serial(now, memory);
        self.tick_io(now, memory);
        self.tick_adc1(now, memory);
        self.tick_card(now, memory);
        self.tick_usb(now);
        self.refresh_lines(now);
    }

    /// When something will happen next without the core doing anything.
    pub(crate) fn next_event(&self) -> Option<Ticks> {
        let timers =
            [&self.tim1, &self.tim2, &self.tim3, &self.tim5].into_iter().filter_map(|timer| timer.next_event());
        let others = [
            self.private.systick.next_event(self.clocks.core),
            self.spi1.next_event(),
            self.spi2.next_event(),
            self.usart2.next_event(),
            self.usart3.next_event(),
            self.usart6.next_event(),
            self.card_event(),
            self.io.next_event(),
            self.usb.next_event(),
            self.mpu6000.next_event(),
            self.l3gd20.next_event(),
            self.lsm303d.next_event(),
            self.iwdg.next_event(),
            self.dip_end.map(|(end, _)| end),
            self.adc1.next_end().filter(|_| self.dma[1].is_waited_for(4)),
        ];
        timers.chain(others.into_iter().flatten()).min()
    }

    /// The supply of chip and board.
    pub(crate) fn set_supply_v(&mut self, supply_v: f32) {
        self.pwr.set_supply_v(supply_v);
        self.refresh_lines(self.now);
    }

    /// It dips for so long.
    pub(crate) fn dip_supply(&mut self, supply_v: f32, duration: Ticks) {
        self.dip_end = Some((self.now + duration, self.pwr.supply_v()));
        self.set_supply_v(supply_v);
    }

    /// The crystal stops, or would start.
    pub(crate) fn set_crystal(&mut self, oscillates: bool) {
        if !self.rcc.set_crystal(oscillates) {
            self.refuse(Cause::Unmodelled("the crystal stopped and the clock security system is off"), 0, None);
        }
        self.distribute_clocks();
        self.refresh_lines(self.now);
    }

    fn refuse(&mut self, cause: Cause, address: u32, value: Option<u32>) {
        // the first is the cause, the rest may follow from it
        self.stop.get_or_insert(Stop { cause, address, value, pc: 0 });
    }
}

#[cfg(test)]
mod tests;
