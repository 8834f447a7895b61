//! The two IMUs on their one bus: data-ready, DMA, sample queues.
//!
//! ```text
//!   MPU6000 ready -> transfer ------------------------> first queue
//!   L3GD20 ready  -> transfer -> LSM303D's transfer ---> second queue;  behind each a register is looked at
//! ```
//! Who comes while the bus is busy waits and is served when the transfer under way ends, the first IMU before the
//! second. A transfer that does not end in [`TRANSFER_MAX_US`] is broken off by whatever comes next, at the latest by
//! the loop, which looks in once a step: neither sensor can keep the bus from the other.
#![allow(unsafe_code)] // addresses and buffers of the DMA

use core::ptr;
use core::sync::atomic::{Ordering, fence};

use shared_control::sensing::imu::AxisMap;
use shared_control::signals::RawImuSample;
use stm32f4xx_hal::gpio::{ExtiPin, Input, PB0, PD15};
use stm32f4xx_hal::pac::{DMA2, EXTI};
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::clock;
use super::counters::{FIRST_IMU, SECOND_IMU};
use super::queue::{Producer, Queue};
use super::register_watch::{Access, RegisterWatch};
use super::sensor_bus::{Chip, READ, SensorBus, SensorFault};
use super::transfer::{Buffers, Transfer};
use super::watches::Watches;
use super::{l3gd20, lsm303d, mpu6000};

/// A transfer takes 13 us, one of a register 25; what lasts this long has failed.
const TRANSFER_MAX_US: u32 = 200;
/// Longest wait for a DMA stream to stop, turns of a loop; it takes a few cycles.
const STOP_TURNS: u32 = 100;
/// Room for the samples of two steps at 100 Hz.
pub const QUEUE_LENGTH: usize = 32;

/// A sample, its time still a counter value.
#[derive(Clone, Copy)]
pub struct TimedSample {
    /// Microsecond counter at data-ready.
    pub counter_us: u32,
    /// Rotation rate, counts.
    pub gyro_counts: [i16; 3],
    /// Specific force, counts.
    pub accel_counts: [i16; 3],
}

impl TimedSample {
    /// The sample with its time in full, µs.
    pub fn at(&self, time_us: u64) -> RawImuSample {
        RawImuSample { time_us, gyro_counts: self.gyro_counts, accel_counts: self.accel_counts }
    }
}

/// From the interrupts to the loop.
pub type SampleQueue = Queue<TimedSample, QUEUE_LENGTH>;

/// Data-ready of both IMUs.
pub struct ReadyPins {
    /// MPU6000: pulses.
    pub first: PD15<Input>,
    /// L3GD20: high from a new sample until it is read.
    pub second: PB0<Input>,
}

/// What the checks of the sensors found.
pub struct Checked {
    first: Result<RegisterWatch, SensorFault>,
    second: Result<(AxisMap, [RegisterWatch; 2]), SensorFault>,
}

impl Checked {
    /// Sets all of them up; one that does not pass is reported and never delivers.
    pub fn set_up(bus: &mut SensorBus) -> Self {
        // the second first, since its gyro takes a while to settle
        let second = l3gd20::set_up(bus)
            .and_then(|(axes, gyro)| lsm303d::set_up(bus).map(|accelerometer| (axes, [gyro, accelerometer])));
        Self { first: mpu6000::set_up(bus), second }
    }

    /// The axes of the second gyro, of which there are two variants.
    pub fn second_gyro_axes(&self) -> Option<AxisMap> {
        self.second.as_ref().ok().map(|(axes, _)| *axes)
    }

    /// For a person.
    pub fn faults(&self) -> impl Iterator<Item = SensorFault> {
        let faults = [self.first.as_ref().err().copied(), self.second.as_ref().err().copied()];
        faults.into_iter().flatten()
    }
}

#[derive(Clone, Copy)]
struct UnderWay {
    transfer: Transfer,
    /// Of the sample.
    counter_us: u32,
    began_us: u32,
}

/// Both IMUs, their bus, and its DMA streams: 0 receives, 5 sends.
pub struct Imus {
    bus: SensorBus,
    dma: DMA2,
    ready: ReadyPins,
    buffers: &'static mut Buffers,
    samples: Producer<'static, TimedSample>,
    samples_second: Producer<'static, TimedSample>,
    second_is_usable: bool,
    under_way: Option<UnderWay>,
    first_due_us: Option<u32>,
    second_due_us: Option<u32>,
    watches: Watches,
}

const RECEIVE: usize = 0;
const SEND: usize = 5;
const CHANNEL: u8 = 3;

impl Imus {
    /// The sensors, already set up, on a bus that from now on is theirs alone.
    pub fn new(
        bus: SensorBus,
        dma: DMA2,
        ready: ReadyPins,
        buffers: &'static mut Buffers,
        [samples, samples_second]: [Producer<'static, TimedSample>; 2],
        rcc: &mut Rcc,
    ) -> Self {
        DMA2::enable(rcc);
        DMA2::reset(rcc);
        bus.hand_to_dma();
        let imus = Self {
            bus,
            dma,
            ready,
            buffers,
            samples,
            samples_second,
            second_is_usable: false,
            under_way: None,
            first_due_us: None,
            second_due_us: None,
            watches: Watches::NONE,
        };
        imus.prepare_dma();
        imus
    }

    fn prepare_dma(&self) {
        let data_register = self.bus.spi.dr().as_ptr() as u32;
        let receive = self.dma.st(RECEIVE);
        receive.cr().write(|w| {
            w.chsel().set(CHANNEL).dir().peripheral_to_memory().minc().set_bit().pl().very_high();
            w.tcie().set_bit().teie().set_bit()
        });
        let send = self.dma.st(SEND);
        send.cr().write(|w| w.chsel().set(CHANNEL).dir().memory_to_peripheral().minc().set_bit().pl().high());
        // SAFETY: the SPI's register, and a buffer that lives for ever and outside the CCM
        unsafe {
            receive.par().write(|w| w.pa().bits(data_register));
            receive.m0ar().write(|w| w.m0a().bits(ptr::addr_of!(self.buffers.received) as u32));
            send.par().write(|w| w.pa().bits(data_register));
        }
    }

    /// Listens to those that passed.
    pub fn start(&mut self, checked: Checked, exti: &mut EXTI) {
        let first_is_usable = checked.first.is_ok();
        self.second_is_usable = checked.second.is_ok();
        let second = checked.second.ok().map(|(_, watches)| watches);
        self.watches = Watches::new(checked.first.ok(), second, clock::now_us());
        if first_is_usable {
            self.ready.first.clear_interrupt_pending_bit();
            self.ready.first.enable_interrupt(exti);
        }
        if self.second_is_usable {
            self.ready.second.clear_interrupt_pending_bit();
            self.ready.second.enable_interrupt(exti);
        }
    }

    /// The first IMU has a sample.
    pub fn first_ready(&mut self) {
        let now_us = clock::now_us();
        self.ready.first.clear_interrupt_pending_bit();
        if self.first_due_us.replace(now_us).is_some() {
            FIRST_IMU.overruns.add();
        }
        self.serve(now_us);
    }

    /// The second may have one, if its pin is high; or a step has passed, and a lost edge or a transfer that hangs is
    /// looked for.
    pub fn second_ready(&mut self) {
        let now_us = clock::now_us();
        self.ready.second.clear_interrupt_pending_bit();
        // until its gyro is read, the pin stays high
        let is_asked = matches!(self.under_way, Some(UnderWay { transfer: Transfer::L3gd20, .. }));
        if self.second_is_usable && !is_asked && self.ready.second.is_high() {
            self.second_due_us = self.second_due_us.or(Some(now_us));
        }
        self.serve(now_us);
        if self.under_way.is_none()
            && let Some(chip) = self.watches.silent(now_us)
        {
            self.begin_access(chip, now_us);
        }
    }

    /// A transfer has ended, well or badly: hands the sample on, and goes on with what is due.
    pub fn received(&mut self) {
        let flags = self.dma.lisr().read();
        let Some(UnderWay { transfer, counter_us, .. }) = self.under_way else {
            self.clear_flags();
            return;
        };
        let now_us = clock::now_us();
        if flags.teif0().bit_is_set() {
            self.break_off(transfer);
        } else if flags.tcif0().bit_is_set() {
            self.clear_flags();
            self.release(transfer);
            self.under_way = None;
            fence(Ordering::Acquire);
            self.take(transfer, counter_us, now_us);
            self.serve(now_us);
            self.look_at_registers(transfer, now_us);
            return;
        }
        self.serve(now_us);
    }

    fn take(&mut self, transfer: Transfer, counter_us: u32, now_us: u32) {
        // SAFETY: the DMA has ended, and the volatile read sees what it wrote
        let bytes = unsafe { ptr::addr_of!(self.buffers.received).read_volatile() };
        let [b0, b1, b2, b3, b4, b5, b6, b7, ..] = bytes;
        let half = [b0, b1, b2, b3, b4, b5, b6, b7];
        let (sample, queue) = match transfer {
            Transfer::Mpu6000 => (mpu6000::decode(&bytes), &mut self.samples),
            Transfer::L3gd20 => {
                match l3gd20::decode(&half) {
                    Some(gyro_counts) => self.begin(Transfer::Lsm303d(gyro_counts), counter_us, now_us),
                    None => SECOND_IMU.old.add(),
                }
                return;
            }
            Transfer::Lsm303d(gyro) => (l3gd20::decode(&half).map(|accel| (gyro, accel)), &mut self.samples_second),
            Transfer::Register(chip) => {
                if let Some(watch) = self.watches.of(chip) {
                    watch.answered(b1, now_us);
                }
                return;
            }
        };
        let is_trusted = match transfer {
            Transfer::Mpu6000 => self.watches.trust_first(now_us),
            _ => self.watches.trust_second(now_us),
        };
        match sample {
            _ if !is_trusted => {}
            None => transfer.counters().old.add(),
            Some((gyro_counts, accel_counts)) => {
                if queue.enqueue(TimedSample { counter_us, gyro_counts, accel_counts }).is_err() {
                    transfer.counters().dropped.add();
                }
            }
        }
    }

    /// Begins what is due, unless the bus is busy.
    fn serve(&mut self, now_us: u32) {
        if let Some(UnderWay { transfer, began_us, .. }) = self.under_way {
            if now_us.wrapping_sub(began_us) < TRANSFER_MAX_US {
                return;
            }
            self.break_off(transfer);
        }
        if let Some(counter_us) = self.first_due_us.take() {
            self.begin(Transfer::Mpu6000, counter_us, now_us);
        } else if let Some(counter_us) = self.second_due_us.take() {
            self.begin(Transfer::L3gd20, counter_us, now_us);
        }
    }

    /// Right behind a sample, since reading a register of the MPU6000 takes back that its next one is ready.
    fn look_at_registers(&mut self, ended: Transfer, now_us: u32) {
        if self.under_way.is_none()
            && let Some(chip) = self.watches.behind(ended)
        {
            self.begin_access(chip, now_us);
        }
    }

    /// What the watch over a chip's registers wants.
    fn begin_access(&mut self, chip: Chip, now_us: u32) {
        let Some(access) = self.watches.of(chip).and_then(|watch| watch.access()) else { return };
        let [address, value] = match access {
            Access::Read(register) => [READ | register, 0],
            Access::Write(register, value) => [register, value],
        };
        [self.buffers.register[0], self.buffers.register[1]] = [address, value];
        self.begin(Transfer::Register(chip), now_us, now_us);
    }

    fn release(&mut self, transfer: Transfer) {
        match transfer {
            Transfer::Register(_) => self.bus.release_register(transfer.chip()),
            _ => self.bus.release(transfer.chip()),
        }
    }

    fn begin(&mut self, transfer: Transfer, counter_us: u32, began_us: u32) {
        self.under_way = Some(UnderWay { transfer, counter_us, began_us });
        let request = match transfer {
            Transfer::Mpu6000 => &self.buffers.mpu6000,
            Transfer::L3gd20 => &self.buffers.l3gd20,
            Transfer::Lsm303d(_) => &self.buffers.lsm303d,
            Transfer::Register(_) => &self.buffers.register,
        };
        self.clear_flags();
        // SAFETY: a buffer that lives for ever and outside the CCM
        unsafe { self.dma.st(SEND).m0ar().write(|w| w.m0a().bits(ptr::addr_of!(*request) as u32)) };
        match transfer {
            Transfer::Register(_) => self.bus.begin_register(transfer.chip()),
            _ => self.bus.begin_sample(transfer.chip()),
        }
        fence(Ordering::Release);
        for stream in [RECEIVE, SEND] {
            self.dma.st(stream).ndtr().write(|w| w.ndt().set(transfer.bytes()));
            self.dma.st(stream).cr().modify(|_, w| w.en().set_bit());
        }
    }

    fn break_off(&mut self, transfer: Transfer) {
        transfer.counters().broken_off.add();
        for stream in [SEND, RECEIVE] {
            self.dma.st(stream).cr().modify(|_, w| w.en().clear_bit());
        }
        // the item under way may still end (RM 10.3.14)
        for _ in 0..STOP_TURNS {
            if [SEND, RECEIVE].iter().all(|stream| self.dma.st(*stream).cr().read().en().bit_is_clear()) {
                break;
            }
        }
        self.bus.start_over(transfer.chip());
        self.under_way = None;
    }

    fn clear_flags(&self) {
        self.dma.lifcr().write(|w| {
            w.cfeif0().set_bit().cdmeif0().set_bit().cteif0().set_bit().chtif0().set_bit().ctcif0().set_bit()
        });
        self.dma.hifcr().write(|w| {
            w.cfeif5().set_bit().cdmeif5().set_bit().cteif5().set_bit().chtif5().set_bit().ctcif5().set_bit()
        });
    }
}
