//! Which pin does what (Pixhawk 1, FMUv2 schematic), each in the state that is safe until its device is set up.

use stm32f4xx_hal::gpio::{Edge, ExtiPin, Input, Output, PD15, PE3, PinState, Pull, Speed};
use stm32f4xx_hal::pac::{EXTI, GPIOA, GPIOC, GPIOD, GPIOE, SYSCFG};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;

use super::{light_and_tone, link_port, outputs, sensor_bus};

/// The pins in use.
pub struct Pins {
    /// Chip selects on SPI1, all high.
    pub selects: sensor_bus::Selects,
    /// SPI1.
    pub sensor_bus: sensor_bus::Pins,
    /// Supply of the sensors: high is on.
    pub sensor_supply: PE3<Output>,
    /// Data-ready of the MPU6000, interrupt on its rising edge.
    pub imu_ready: PD15<Input>,
    /// AUX 4 to 1.
    pub motors: outputs::Pins,
    /// TELEM1.
    pub link: link_port::Pins,
    /// LED.
    pub light_and_tone: light_and_tone::Pins,
}

impl Pins {
    /// Takes and sets up all of them.
    pub fn new(ports: (GPIOA, GPIOC, GPIOD, GPIOE), syscfg: SYSCFG, exti: &mut EXTI, rcc: &mut Rcc) -> Self {
        let (a, c) = (ports.0.split(rcc), ports.1.split(rcc));
        let (d, e) = (ports.2.split(rcc), ports.3.split(rcc));
        let high = PinState::High;
        let selects = sensor_bus::Selects {
            mpu6000: c.pc2.into_push_pull_output_in_state(high),
            _unused: (
                c.pc13.into_push_pull_output_in_state(high),
                c.pc15.into_push_pull_output_in_state(high),
                d.pd7.into_push_pull_output_in_state(high),
            ),
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
        let mut imu_ready = d.pd15.into_floating_input();
        imu_ready.make_interrupt_source(&mut syscfg.constrain(rcc));
        imu_ready.trigger_on_edge(exti, Edge::Rising);
        Self {
            selects,
            sensor_bus,
            sensor_supply: e.pe3.into_push_pull_output_in_state(PinState::Low),
            imu_ready,
            motors,
            link: (d.pd5.into_alternate(), d.pd6.into_alternate().internal_resistor(Pull::Up)),
            light_and_tone: light_and_tone::Pins { led: e.pe12.into_open_drain_output_in_state(high) },
        }
    }
}
