//! The tasks and what they share. One device a file; the mathematics is all in `shared_control`.
//!
//! ```text
//!  7  low_supply               supply detector: motors to the disarmed pulse, reset
//!  6  imu_ready, imu_received  data-ready -> DMA -> sample queue
//!  5  control_step             TIM3: samples since the last step -> fast -> pulses -> follow
//!  2  plan                     MPC; its result is used by the next step, a late one by none
//!  1  housekeeping             LED, load, watchdog
//! ```

mod board;
mod boot;
mod clock;
mod control;
mod fault;
mod imu;
mod led;
mod load;
mod loop_timer;
mod outputs;
mod pins;
mod sensor_bus;
mod supply;
mod trace;
mod watchdog;

use defmt_rtt as _;

#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true, dispatchers = [CAN1_TX, CAN1_RX0, CAN1_RX1])]
mod app {
    use core::sync::atomic::Ordering;

    use cortex_m::asm;
    use shared_control::config::mpc_settings;
    use shared_control::flight_core::FlightCore;
    use shared_control::mpc::{Mpc, MpcState};
    use shared_control::signals::{MotorCommands, Plan, PlanRequest};
    use shared_control::supervisor::Arming;
    use shared_control::vehicle::VehicleParameters;

    use super::board::{self, CONTROL_HORIZON};
    use super::control::{self, Command, Control};
    use super::fault::{self, Cause, FaultRecord};
    use super::imu::{Buffers, Imu, SampleQueue};
    use super::led::{Led, Sign};
    use super::load;
    use super::loop_timer::LoopTimer;
    use super::outputs::Outputs;
    use super::pins::Pins;
    use super::sensor_bus::SensorBus;
    use super::trace::Trace;
    use super::watchdog::{self, Watchdog};
    use super::{boot, clock, supply};

    /// Steps of the loop per housekeeping: 100 times a second.
    const HOUSEKEEPING_STEPS: u32 = board::LOOP_RATE_HZ / 100;

    #[shared]
    struct Shared {
        #[lock_free]
        imu: Imu,
        command: Command,
        plan: Option<Plan>,
        sign: Sign,
    }

    #[local]
    struct Local {
        control: Control,
        outputs: Outputs,
        loop_timer: LoopTimer,
        trace: Trace,
        mpc: Mpc<CONTROL_HORIZON>,
        mpc_state: MpcState<CONTROL_HORIZON>,
        led: Led,
        watchdog: Watchdog,
    }

    /// Interrupts are off until it returns. What is wrong with the compiled-in configuration stops the program here.
    #[init(local = [samples: SampleQueue = SampleQueue::new(), buffers: Buffers = Buffers::NEW])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let (mut core, mut device) = (cx.core, cx.device);
        let reset_flags = boot::take_reset_flags(&device.RCC);
        boot::release_clocks(&device.RCC, &device.EXTI);
        let mut rcc = clock::start(device.RCC, &device.FLASH);
        clock::freeze_on_halt(&device.DBGMCU);
        clock::start_microseconds(&device.TIM5, &mut rcc);
        load::start(&mut core.DCB, &mut core.DWT);
        defmt::info!("reset flags {=u32:#x}, fault before: {}", reset_flags, FaultRecord::take());

        let ports = (device.GPIOA, device.GPIOC, device.GPIOD, device.GPIOE);
        let mut pins = Pins::new(ports, device.SYSCFG, &mut device.EXTI, &mut rcc);
        supply::watch(&device.PWR, &device.EXTI, &mut rcc);

        let (config, tuning) = control::configuration().expect("the compiled-in configuration");
        let mpc = Mpc::prepare(&mpc_settings(&VehicleParameters::F450_GIMBAL, &tuning)).expect("its MPC");

        let disarmed = config.output.compare_counts(&MotorCommands::default(), false);
        let outputs = Outputs::new(device.TIM1, pins.motors, disarmed[0], &mut rcc);
        let loop_timer = LoopTimer::new(device.TIM3, &mut rcc);

        let (producer, consumer) = cx.local.samples.split();
        let bus = SensorBus::new(device.SPI1, pins.sensor_bus, pins.selects, &mut pins.sensor_supply, &mut rcc);
        let mut imu = Imu::new(bus, device.DMA2, pins.imu_ready, cx.local.buffers, producer, &mut rcc);
        if let Err(fault) = imu.start(&mut device.EXTI) {
            // without samples the estimate stays invalid, and the supervisor does not arm
            defmt::error!("MPU6000 is not used: {}", fault);
        }

        let watchdog = Watchdog::start(device.IWDG);
        loop_timer.start();
        let shared = Shared { imu, command: Command::default(), plan: None, sign: Sign::Disarmed };
        let local = Local {
            control: Control::new(config, consumer),
            outputs,
            loop_timer,
            trace: Trace::new(),
            mpc,
            mpc_state: MpcState::new(),
            led: Led::new(pins.led),
            watchdog,
        };
        (shared, local)
    }

    /// Every 1 ms, done within 2 us. On a miss the sample is given up and counted.
    #[task(binds = EXTI15_10, priority = 6, shared = [imu])]
    fn imu_ready(cx: imu_ready::Context) {
        cx.shared.imu.begin_transfer();
    }

    /// About 15 us after [`imu_ready`], done before the next. On a miss that next sample is given up and counted.
    #[task(binds = DMA2_STREAM0, priority = 6, shared = [imu])]
    fn imu_received(cx: imu_received::Context) {
        cx.shared.imu.end_transfer();
    }

    /// Every loop period; its pulses must be written within `board::PULSE_DELAY_US`. On a miss the pulses before are sent
    /// once more; a step that outlasts the period is counted, and without any the watchdog resets the board.
    #[task(
        binds = TIM3, priority = 5,
        local = [control, outputs, loop_timer, trace], shared = [command, plan, sign]
    )]
    fn control_step(mut cx: control_step::Context) {
        let local = cx.local;
        local.loop_timer.acknowledge();
        let output = load::LOOP.measure(|| {
            let command = cx.shared.command.lock(Command::take);
            let plan = cx.shared.plan.lock(Option::take);
            let output = local.control.fast(&command, plan);
            local.outputs.write(output.compare_counts, output.arming == Arming::Armed);
            if let Some(request) = local.control.follow(&output)
                && plan::spawn(request).is_err()
            {
                // the plan before is still being made: the next step does without
                load::LATE_PLANS.fetch_add(1, Ordering::Relaxed);
            }
            local.trace.publish(local.control.input(), &output);
            output
        });
        cx.shared.sign.lock(|sign| *sign = Sign::of(&output));
        if local.loop_timer.is_late() {
            load::OVERRUNS.fetch_add(1, Ordering::Relaxed);
        }
        watchdog::report_loop();
        if output.step.is_multiple_of(HOUSEKEEPING_STEPS) {
            // still busy with the one before: the watchdog notices if that lasts
            let _ = housekeeping::spawn();
        }
    }

    /// In MPC mode once a step, to be done before the next. On a miss that next step takes the cascade's torque, and its
    /// own request is not made.
    #[task(priority = 2, local = [mpc, mpc_state], shared = [plan])]
    async fn plan(mut cx: plan::Context, request: PlanRequest) {
        let plan = load::PLAN.measure(|| FlightCore::plan(cx.local.mpc, cx.local.mpc_state, &request));
        cx.shared.plan.lock(|latest| *latest = Some(plan));
    }

    /// Every 10 ms, done within 20 ms of the last. On a miss the watchdog resets the board.
    #[task(priority = 1, local = [led, watchdog, ticks: u32 = 0], shared = [sign])]
    async fn housekeeping(mut cx: housekeeping::Context) {
        let local = cx.local;
        local.watchdog.feed_if_all_alive();
        *local.ticks = local.ticks.wrapping_add(1);
        if local.ticks.is_multiple_of(10) {
            local.led.update(cx.shared.sign.lock(|sign| *sign));
        }
        if local.ticks.is_multiple_of(100) {
            load::report();
        }
    }

    /// At once, before anything else. There is no second chance: the supply is failing.
    #[task(binds = PVD, priority = 7)]
    fn low_supply(_: low_supply::Context) {
        fault::stop(Cause::LowSupply, 0, 0);
    }

    /// Nothing to do: sleep until an interrupt.
    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            asm::wfi();
        }
    }
}
