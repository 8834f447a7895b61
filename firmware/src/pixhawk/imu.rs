//! MPU6000: registers, data-ready, one DMA transfer per sample. Register map RM-MPU-6000A-00 revision 4.2.
#![allow(unsafe_code)] // addresses and buffers of the DMA

use core::ptr;
use core::sync::atomic::{Ordering, fence};

use shared_control::setup::IMU_RATE_HZ;
use shared_control::signals::RawImuSample;
use stm32f4xx_hal::gpio::{ExtiPin, Input, PD15};
use stm32f4xx_hal::pac::{DMA2, EXTI};
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::clock;
use super::counters;
use super::queue::{Producer, Queue};
use super::sensor_bus::{READ, SensorBus};

const PWR_MGMT_1: u8 = 0x6B;
const WHO_AM_I: u8 = 0x75;
const IDENTITY: u8 = 0x68;
/// First register of a sample: INT_STATUS, then acceleration, temperature, rotation, each high byte first.
const INT_STATUS: u8 = 0x3A;
const DATA_READY: u8 = 1;

/// What is written, in this order, and must read back.
const SETTINGS: [(u8, u8); 9] = [
    (PWR_MGMT_1, 0x01),                     // awake, clock from the gyro
    (0x6C, 0x00),                           // PWR_MGMT_2: all axes on
    (0x6A, 0x10),                           // USER_CTRL: I2C off, or bus traffic for others may switch it on
    (0x1A, 0x00),                           // CONFIG: 256 Hz, the least delay; gyro at 8 kHz
    (0x19, (8000 / IMU_RATE_HZ - 1) as u8), // SMPLRT_DIV
    (0x1B, 0x18),                           // GYRO_CONFIG: +-2000 deg/s
    (0x1C, 0x10),                           // ACCEL_CONFIG: +-8 g
    (0x37, 0x10),                           // INT_PIN_CFG: 50 us pulse, cleared by any read
    (0x38, DATA_READY),                     // INT_ENABLE
];

/// Address, status, three accelerations, temperature, three rotations.
pub const TRANSFER_BYTES: usize = 16;
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

/// Buffers of the DMA. They must not lie on the stack, which is out of its reach.
pub struct Buffers {
    /// What the sensor answers.
    pub received: [u8; TRANSFER_BYTES],
    /// The address; the rest only makes clocks.
    pub sent: [u8; TRANSFER_BYTES],
}

impl Buffers {
    /// A read from INT_STATUS on.
    pub const NEW: Self = {
        let mut sent = [0; TRANSFER_BYTES];
        sent[0] = READ | INT_STATUS;
        Self { received: [0; TRANSFER_BYTES], sent }
    };
}

/// Why the sensor is not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub enum ImuFault {
    /// Somebody else, or nobody, answers; with the answer.
    Identity(u8),
    /// A register did not keep what was written; with its address.
    Register(u8),
}

impl ImuFault {
    /// For a person.
    pub fn words(self) -> &'static str {
        match self {
            Self::Identity(_) => "MPU6000 does not answer as itself",
            Self::Register(_) => "MPU6000 does not keep its settings",
        }
    }
}

/// The sensor with its DMA streams: 0 receives, 5 sends.
pub struct Imu {
    bus: SensorBus,
    dma: DMA2,
    data_ready: PD15<Input>,
    buffers: &'static mut Buffers,
    samples: Producer<'static, TimedSample>,
    due_us: u32,
    busy: bool,
}

const RECEIVE: usize = 0;
const SEND: usize = 5;
const CHANNEL: u8 = 3;

impl Imu {
    /// The sensor on a bus that nobody else uses, not yet set up.
    pub fn new(
        bus: SensorBus,
        dma: DMA2,
        data_ready: PD15<Input>,
        buffers: &'static mut Buffers,
        samples: Producer<'static, TimedSample>,
        rcc: &mut Rcc,
    ) -> Self {
        DMA2::enable(rcc);
        DMA2::reset(rcc);
        Self { bus, dma, data_ready, buffers, samples, due_us: 0, busy: false }
    }

    /// Checks who answers, writes the settings, reads them back, and goes over to DMA.
    pub fn start(&mut self, exti: &mut EXTI) -> Result<(), ImuFault> {
        self.bus.write(PWR_MGMT_1, 0x80); // DEVICE_RESET
        clock::wait_us(100 * 1000);
        let identity = self.bus.read(WHO_AM_I);
        if identity != IDENTITY {
            return Err(ImuFault::Identity(identity));
        }
        for (register, value) in SETTINGS {
            self.bus.write(register, value);
        }
        // the gyro's oscillator takes over
        clock::wait_us(50 * 1000);
        for (register, value) in SETTINGS {
            if self.bus.read(register) != value {
                return Err(ImuFault::Register(register));
            }
        }
        self.bus.fast();
        self.prepare_dma();
        self.data_ready.clear_interrupt_pending_bit();
        self.data_ready.enable_interrupt(exti);
        Ok(())
    }

    fn prepare_dma(&mut self) {
        let data_register = self.bus.spi.dr().as_ptr() as u32;
        let receive = self.dma.st(RECEIVE);
        receive.cr().write(|w| {
            w.chsel().set(CHANNEL).dir().peripheral_to_memory().minc().set_bit().pl().very_high();
            w.tcie().set_bit().teie().set_bit()
        });
        let send = self.dma.st(SEND);
        send.cr().write(|w| w.chsel().set(CHANNEL).dir().memory_to_peripheral().minc().set_bit().pl().high());
        // SAFETY: the SPI's register, and buffers that live for ever and outside the CCM
        unsafe {
            receive.par().write(|w| w.pa().bits(data_register));
            receive.m0ar().write(|w| w.m0a().bits(ptr::addr_of!(self.buffers.received) as u32));
            send.par().write(|w| w.pa().bits(data_register));
            send.m0ar().write(|w| w.m0a().bits(ptr::addr_of!(self.buffers.sent) as u32));
        }
    }

    /// At data-ready: notes the time and starts the transfer.
    pub fn begin_transfer(&mut self) {
        let now_us = clock::now_us();
        self.data_ready.clear_interrupt_pending_bit();
        if self.busy {
            counters::IMU_OVERRUNS.add();
            self.abort();
            return;
        }
        self.busy = true;
        self.due_us = now_us;
        self.bus.select();
        self.clear_flags();
        fence(Ordering::Release);
        for stream in [RECEIVE, SEND] {
            self.dma.st(stream).ndtr().write(|w| w.ndt().set(TRANSFER_BYTES as u16));
            self.dma.st(stream).cr().modify(|_, w| w.en().set_bit());
        }
    }

    /// At the transfer's end: hands the sample on.
    pub fn end_transfer(&mut self) {
        let failed = self.dma.lisr().read().teif0().bit_is_set();
        if failed {
            counters::IMU_BROKEN_OFF.add();
            self.abort();
            return;
        }
        self.clear_flags();
        self.bus.release();
        self.busy = false;
        fence(Ordering::Acquire);
        // SAFETY: the DMA has ended, and the volatile read sees what it wrote
        let bytes = unsafe { ptr::addr_of!(self.buffers.received).read_volatile() };
        let (status, sample) = decode(self.due_us, &bytes);
        if status & DATA_READY == 0 {
            counters::IMU_OLD.add();
        } else if self.samples.enqueue(sample).is_err() {
            counters::IMU_DROPPED.add();
        }
    }

    fn abort(&mut self) {
        for stream in [SEND, RECEIVE] {
            self.dma.st(stream).cr().modify(|_, w| w.en().clear_bit());
        }
        self.clear_flags();
        self.bus.release();
        self.busy = false;
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

/// Status and sample of a transfer.
fn decode(counter_us: u32, bytes: &[u8; TRANSFER_BYTES]) -> (u8, TimedSample) {
    let [_, status, ax1, ax0, ay1, ay0, az1, az0, _, _, gx1, gx0, gy1, gy0, gz1, gz0] = *bytes;
    let word = |high, low| i16::from_be_bytes([high, low]);
    let sample = TimedSample {
        counter_us,
        accel_counts: [word(ax1, ax0), word(ay1, ay0), word(az1, az0)],
        gyro_counts: [word(gx1, gx0), word(gy1, gy0), word(gz1, gz0)],
    };
    (status, sample)
}
