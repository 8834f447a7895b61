//! Which pin does what (Pixhawk 1, FMUv2 schematic), each in the state that is safe until its device is set up.

use stm32f4xx_hal::gpio::{Edge, ExtiPin, Output, PD10, PE3, PinState, Pull, Speed};
use stm32f4xx_hal::pac::{EXTI, GPIOA, GPIOB, GPIOC, GPIOD, GPIOE, SYSCFG};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;

use super::{battery, fram, imu, io_port, light_and_tone, link_port, outputs, sd_bus, sensor_bus, usb_port};

/// The ports that they belong to.
pub type Ports = (GPIOA, GPIOB, GPIOC, GPIOD, GPIOE);

/// The pins in use.
pub struct Pins {
    /// Chip selects on SPI1, all low as long as the sensors have no supply.
    pub selects: sensor_bus::Selects,
    /// SPI1.
    pub sensor_bus: sensor_bus::Pins,
    /// Supply of the sensors: high is on.
    pub sensor_supply: PE3<Output>,
    /// Data-ready of both IMUs, interrupts on rising edges.
    pub imu_ready: imu::ReadyPins,
    /// Chip select of the FRAM, high.
    pub fram_select: PD10<Output>,
    /// SPI2.
    pub fram: fram::Pins,
    /// AUX 4 to 1, low.
    pub motors: outputs::Pins,
    /// TELEM1.
    pub link: link_port::Pins,
    /// The IO chip.
    pub io: io_port::Pins,
    /// LED and buzzer.
    pub light_and_tone: light_and_tone::Pins,
    /// The battery's voltage behind its divider.
    pub battery: battery::Pin,
    /// USB's data lines.
    pub usb: usb_port::Lines,
    /// Whether its connector has 5 V.
    pub usb_power: usb_port::Power,
    /// SDIO.
    pub card: sd_bus::Pins,
}

impl Pins {
    /// Takes and sets up all of them.
    pub fn new(ports: Ports, syscfg: SYSCFG, exti: &mut EXTI, rcc: &mut Rcc) -> Self {
        let (high, low) = (PinState::High, PinState::Low);
        // first, since `split` lets the pins of its port go, for a tenth of a microsecond
        let e = ports.4.split(rcc);
        let motors = (
            e.pe9.into_push_pull_output_in_state(low),
            e.pe11.into_push_pull_output_in_state(low),
            e.pe13.into_push_pull_output_in_state(low),
            e.pe14.into_push_pull_output_in_state(low),
        );
        let sensor_supply = e.pe3.into_push_pull_output_in_state(low);
        let (a, b, c) = (ports.0.split(rcc), ports.1.split(rcc), ports.2.split(rcc));
        let d = ports.3.split(rcc);
        let selects = sensor_bus::Selects {
            mpu6000: c.pc2.into_push_pull_output_in_state(low),
            l3gd20: c.pc13.into_push_pull_output_in_state(low),
            lsm303d: c.pc15.into_push_pull_output_in_state(low),
            ms5611: d.pd7.into_push_pull_output_in_state(low),
        };
        let sensor_bus = (
            // where it rests in mode 3 when nobody drives it
            a.pa5.into_alternate().speed(Speed::High).internal_resistor(Pull::Up),
            a.pa6.into_alternate(),
            a.pa7.into_alternate().speed(Speed::High),
        );
        // low where nobody drives them
        let mut imu_ready =
            imu::ReadyPins { first: d.pd15.into_pull_down_input(), second: b.pb0.into_pull_down_input() };
        let mut syscfg = syscfg.constrain(rcc);
        imu_ready.first.make_interrupt_source(&mut syscfg);
        imu_ready.first.trigger_on_edge(exti, Edge::Rising);
        imu_ready.second.make_interrupt_source(&mut syscfg);
        imu_ready.second.trigger_on_edge(exti, Edge::Rising);
        Self {
            selects,
            sensor_bus,
            sensor_supply,
            imu_ready,
            fram_select: d.pd10.into_push_pull_output_in_state(high).speed(Speed::High),
            // slower, the clock comes back too late for the last bit of a byte (ES0206, delayed SCK feedback)
            fram: (
                b.pb13.into_alternate().speed(Speed::High),
                b.pb14.into_alternate(),
                b.pb15.into_alternate().speed(Speed::High),
            ),
            motors,
            link: (d.pd5.into_alternate(), d.pd6.into_alternate().internal_resistor(Pull::Up)),
            io: (c.pc6.into_alternate().speed(Speed::Medium), c.pc7.into_alternate().internal_resistor(Pull::Up)),
            light_and_tone: light_and_tone::Pins {
                led: e.pe12.into_open_drain_output_in_state(high),
                _buzzer: a.pa15.into_alternate(),
            },
            battery: a.pa2.into_analog(),
            usb: (a.pa11.into_alternate(), a.pa12.into_alternate()),
            // the connector's light pulls it low
            usb_power: a.pa9.into_floating_input(),
            // all but the clock rest high, also where no card is there
            card: (
                c.pc8.into_alternate().speed(Speed::High).internal_resistor(Pull::Up),
                c.pc9.into_alternate().speed(Speed::High).internal_resistor(Pull::Up),
                c.pc10.into_alternate().speed(Speed::High).internal_resistor(Pull::Up),
                c.pc11.into_alternate().speed(Speed::High).internal_resistor(Pull::Up),
                c.pc12.into_alternate().speed(Speed::High),
                d.pd2.into_alternate().speed(Speed::High).internal_resistor(Pull::Up),
            ),
        }
    }
}
