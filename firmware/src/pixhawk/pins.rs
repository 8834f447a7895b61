//! Which pin does what (Pixhawk 1, FMUv2 schematic), each in the state that is safe until its device is set up.

use stm32f4xx_hal::gpio::{Edge, ExtiPin, Output, PD10, PE3, PinState, Pull, Speed};
use stm32f4xx_hal::pac::{EXTI, GPIOA, GPIOB, GPIOC, GPIOD, GPIOE, SYSCFG};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;

use super::{battery, fram, imu, light_and_tone, link_port, outputs, sensor_bus};

/// The ports that they belong to.
pub type Ports = (GPIOA, GPIOB, GPIOC, GPIOD, GPIOE);

/// The pins in use.
pub struct Pins {
    /// Chip selects on SPI1, all high.
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
    /// AUX 4 to 1.
    pub motors: outputs::Pins,
    /// TELEM1.
    pub link: link_port::Pins,
    /// LED and buzzer.
    pub light_and_tone: light_and_tone::Pins,
    /// The battery's voltage behind its divider.
    pub battery: battery::Pin,
}

impl Pins {
    /// Takes and sets up all of them.
    pub fn new(ports: Ports, syscfg: SYSCFG, exti: &mut EXTI, rcc: &mut Rcc) -> Self {
        let (a, b, c) = (ports.0.split(rcc), ports.1.split(rcc), ports.2.split(rcc));
        let (d, e) = (ports.3.split(rcc), ports.4.split(rcc));
        let high = PinState::High;
        let selects = sensor_bus::Selects {
            mpu6000: c.pc2.into_push_pull_output_in_state(high),
            l3gd20: c.pc13.into_push_pull_output_in_state(high),
            lsm303d: c.pc15.into_push_pull_output_in_state(high),
            _ms5611: d.pd7.into_push_pull_output_in_state(high),
        };
        let sensor_bus = (
            a.pa5.into_alternate().speed(Speed::High),
            a.pa6.into_alternate(),
            a.pa7.into_alternate().speed(Speed::High),
        );
        // low until the timer drives them, and if it ever lets go
        let mut motors =
            (e.pe9.into_alternate(), e.pe11.into_alternate(), e.pe13.into_alternate(), e.pe14.into_alternate());
        motors.0.set_internal_resistor(Pull::Down);
        motors.1.set_internal_resistor(Pull::Down);
        motors.2.set_internal_resistor(Pull::Down);
        motors.3.set_internal_resistor(Pull::Down);
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
            sensor_supply: e.pe3.into_push_pull_output_in_state(PinState::Low),
            imu_ready,
            fram_select: d.pd10.into_push_pull_output_in_state(high),
            fram: (b.pb13.into_alternate(), b.pb14.into_alternate(), b.pb15.into_alternate()),
            motors,
            link: (d.pd5.into_alternate(), d.pd6.into_alternate().internal_resistor(Pull::Up)),
            light_and_tone: light_and_tone::Pins {
                led: e.pe12.into_open_drain_output_in_state(high),
                _buzzer: a.pa15.into_alternate(),
            },
            battery: a.pa2.into_analog(),
        }
    }
}
