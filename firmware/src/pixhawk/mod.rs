//! The tasks and what they share. One device a file; the mathematics is all in `shared_control`.
//!
//! ```text
//!  7  low_supply               supply detector: motors to the disarmed pulse, reset
//!  6  first_imu_ready, second_imu_ready, imu_received
//!                              data-ready -> DMA -> sample queues
//!  5  control_step             TIM3: samples since the last step -> fast -> pulses -> follow
//!                              in HITL a HIL_SENSOR instead: its sample -> fast -> answer -> follow
//!  4  io_slot, io_replied     IO chip: receiver and safety button -> reports for the loop
//!  3  link_idle, link_ring     TELEM1: bytes -> orders
//!     link_sent                TELEM1: what was waiting for the line
//!  2  plan                     MPC; its result is used by the next step, a late one by none
//!  1  housekeeping             USB, telemetry, light and tone, load, watchdog
//!  0  idle                     the loop's record -> SD card; parameters, lessons -> what the loop takes; sleep
//! ```

mod battery;
mod board;
mod boot;
mod clock;
mod configuration;
mod control;
mod counters;
mod exchange;
mod fault;
mod flight_log;
mod fram;
mod ground;
mod imu;
mod io_port;
mod l3gd20;
mod last_pulse;
mod learner;
mod light_and_tone;
mod link_port;
mod load;
mod loop_timer;
mod lsm303d;
mod mpu6000;
mod outputs;
mod pins;
mod planning;
mod queue;
mod register_watch;
mod sd_bus;
mod sd_card;
mod self_test;
mod sensor_bus;
mod supply;
mod trace;
mod transfer;
mod usb_port;
mod usb_registers;
mod watchdog;
mod watches;

use defmt_rtt as _;

// `plan` and `housekeeping` borrow interrupts of devices that are not used. They are no software tasks of RTIC: those
// are futures, and in each is a panic for one that is polled after its end.
#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true)]
mod app {
    use heapless::Vec;
    use shared_control::flight_core::FlightCore;
    use shared_control::light_and_tone::Sign;
    use shared_control::link::VehicleStatus;
    use shared_control::log_card::LogShelf;
    use shared_control::mpc::{HORIZON, MpcState};
    use shared_control::signals::Plan;
    use stm32f4xx_hal::pac::Interrupt;

    use super::battery::{self, Battery};
    use super::clock::TimeBase;
    use super::configuration::{self, Configuration, MpcPlace};
    use super::control::{AnswerQueue, ChoreQueue, Control, Ends, OrderQueue, TickQueue};
    use super::exchange::{Demand, Offer, Workshop};
    use super::fault::{self, Cause};
    use super::flight_log::{self, FlightLog, FlightRecorder, NewsQueue};
    use super::fram::Fram;
    use super::ground::Ground;
    use super::imu::{Checked, Imus, SampleQueue};
    use super::io_port::{self, IoPort, ReportQueue};
    use super::learner::Slate;
    use super::light_and_tone::LightAndTone;
    use super::link_port::{self, LinkIn, LinkSender, RING_BYTES, SendBuffer};
    use super::load::{self, LoadMeter};
    use super::loop_timer::LoopTimer;
    use super::outputs::Outputs;
    use super::planning::Planning;
    use super::sd_bus::{self, SdBus};
    use super::sd_card::SdCard;
    use super::self_test::SelfTests;
    use super::sensor_bus::SensorBus;
    use super::trace::Trace;
    use super::transfer::Buffers;
    use super::usb_port::UsbPort;
    use super::usb_registers::Registers;
    use super::watchdog::{self, Watchdog};
    use super::{boot, clock, counters, last_pulse, supply};

    #[shared]
    struct Shared {
        #[lock_free]
        imus: Imus,
        #[lock_free]
        io: IoPort,
        link: LinkIn,
        sender: LinkSender,
        planning: Planning,
        plan: Option<Plan>,
        offer: Offer,
        slate: Slate,
        demand: Demand,
        status: VehicleStatus,
        recorder: &'static mut FlightRecorder,
        shelf: LogShelf,
    }

    #[local]
    struct Local {
        control: Control,
        outputs: Outputs,
        loop_timer: LoopTimer,
        trace: Trace,
        housekeeping_ticks: u32,
        mpc_state: MpcState<HORIZON>,
        ground: Ground,
        usb: UsbPort,
        light_and_tone: LightAndTone,
        watchdog: Watchdog,
        workshop: Workshop,
    }

    /// Interrupts are off until it returns.
    #[init(local = [
        samples: SampleQueue = SampleQueue::new(), samples_second: SampleQueue = SampleQueue::new(),
        orders: OrderQueue = OrderQueue::new(),
        reports: ReportQueue = ReportQueue::new(), io_buffers: io_port::Buffers = io_port::Buffers::NEW,
        answers: AnswerQueue = AnswerQueue::new(), chores: ChoreQueue = ChoreQueue::new(),
        imu_buffers: Buffers = Buffers::NEW, ring: [u8; RING_BYTES] = [0; RING_BYTES], buffer: SendBuffer = Vec::new(),
        ticks: TickQueue = TickQueue::new(), conversions: battery::Ring = [0; battery::CONVERSIONS],
        mpc_place: MpcPlace = MpcPlace::uninit(), spare_place: MpcPlace = MpcPlace::uninit(),
        recorder: FlightRecorder = FlightRecorder::new(),
        card_buffer: sd_bus::Buffer = sd_bus::Buffer::NEW, news: NewsQueue = NewsQueue::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let (mut core, mut device) = (cx.core, cx.device);
        let ports = (device.GPIOA, device.GPIOB, device.GPIOC, device.GPIOD, device.GPIOE);
        let (mut rcc, mut pins, start) =
            boot::power_up((device.RCC, &device.PWR, &mut device.EXTI), (ports, device.SYSCFG));
        clock::freeze_on_halt(&device.DBGMCU);
        clock::start_microseconds(&device.TIM5, &mut rcc);
        load::start(&mut core.DCB, &mut core.DWT);

        let mut bus = SensorBus::new(device.SPI1, pins.sensor_bus, pins.selects, &mut pins.sensor_supply, &mut rcc);
        let mut memory = Fram::new(device.SPI2, pins.fram, pins.fram_select, &mut rcc);
        let mut configuration = Configuration::read(&mut memory);
        let (mpc, spare) = (configuration.mpc(cx.local.mpc_place), configuration::unprepared(cx.local.spare_place));
        let disarmed_count = configuration.disarmed_count();
        let setup = &configuration.setup;
        let outputs = Outputs::new(device.TIM1, pins.motors, &setup.pulse_timer, disarmed_count, &mut rcc);
        last_pulse::prepare(disarmed_count, setup.config.output.pulse_min_us() as u16);
        let loop_timer = LoopTimer::new(device.TIM3, &setup.loop_timer, &mut rcc);

        let settings = configuration.link_settings();
        let (answers, answers_out) = cx.local.answers.split();
        let (chores, chores_out) = cx.local.chores.split();
        let (samples, samples_out) = cx.local.samples.split();
        let (samples_second, samples_second_out) = cx.local.samples_second.split();
        let ((ticks, ticks_out), (orders, orders_out)) = (cx.local.ticks.split(), cx.local.orders.split());
        let ((reports, reports_out), (news, news_out)) = (cx.local.reports.split(), cx.local.news.split());
        let (hil, baud) = (configuration.params.hil, configuration.link_baud());
        let buffers = (cx.local.ring, cx.local.buffer);
        let (port, sender) = link_port::open(device.USART2, device.DMA1, pins.link, baud, buffers, &mut rcc);
        let (choices, queues) = (&configuration.params, (answers_out, chores_out, news_out));
        let mut ground = Ground::new(&settings, (choices, memory), queues);
        let link = LinkIn::new(port, (settings, ground.sign(Default::default(), 0)), orders, hil.then_some(ticks));
        ground.tell_start(&start, &configuration);

        let checked = Checked::set_up(&mut bus);
        checked.faults().for_each(|fault| ground.tell(fault.words()));
        let second_gyro = configuration.fit_second_gyro(checked.second_gyro_axes());
        let producers = [samples, samples_second];
        let mut imus = Imus::new(bus, device.DMA2, pins.imu_ready, cx.local.imu_buffers, producers, &mut rcc);
        if !hil {
            imus.start(checked, &mut device.EXTI);
        }
        let io = IoPort::open(device.USART6, pins.io, cx.local.io_buffers, reports, &mut rcc);
        let bus = SdBus::new(device.SDIO, pins.card, cx.local.card_buffer, &mut rcc);
        let workshop = Workshop::new(spare, second_gyro, FlightLog::new(SdCard::new(bus), &configuration.params, news));
        // the simulated vehicle's battery is never low
        let (adc, conversions) = ((device.ADC1, &device.ADC_COMMON), cx.local.conversions);
        let battery = (!hil).then(|| Battery::start(adc, pins.battery, conversions, &mut rcc));

        let (commander, ticks) = (configuration.commander(start.record.is_some()), hil.then_some(ticks_out));
        #[rustfmt::skip]
        let ends = Ends {
            samples: [samples_out, samples_second_out], battery, ticks, reports: reports_out, orders: orders_out,
            answers, chores,
        };
        let control = Control::new(configuration.setup.config, commander, ends);
        let usb = UsbPort::new(Registers::new(device.OTG_FS_GLOBAL), (pins.usb_power, pins.usb), &mut rcc);
        let light_and_tone = LightAndTone::new(device.TIM2, pins.light_and_tone, &mut rcc);
        let watchdog = Watchdog::start(device.IWDG);
        loop_timer.start();
        io_port::start_slots(&mut core.SYST);
        #[rustfmt::skip]
        let local = Local {
            control, outputs, loop_timer, trace: Trace::new(), housekeeping_ticks: configuration.housekeeping_ticks(),
            mpc_state: MpcState::new(), ground, usb, light_and_tone, watchdog, workshop,
        };
        let (status, recorder, shelf) = (configuration.status_at_start(), cx.local.recorder, LogShelf::EMPTY);
        let (planning, offer, demand, slate) = (Planning::new(mpc), Offer::NOTHING, Demand::NOTHING, Slate::BLANK);
        (Shared { imus, io, link, sender, planning, plan: None, offer, slate, demand, status, recorder, shelf }, local)
    }

    /// Every 1 ms, done within 3 us. If it comes while the sample before still waits for the bus, that one is given up
    /// and counted.
    #[task(binds = EXTI15_10, priority = 6, shared = [imus])]
    fn first_imu_ready(cx: first_imu_ready::Context) {
        load::FIRST_IMU.measure(|| cx.shared.imus.first_ready());
    }

    /// Every 1.3 ms, and once a step by [`control_step`]; done within 3 us. If it comes late, so does the sample.
    #[task(binds = EXTI0, priority = 6, shared = [imus])]
    fn second_imu_ready(cx: second_imu_ready::Context) {
        load::SECOND_IMU.measure(|| cx.shared.imus.second_ready());
    }

    /// 15 us after a transfer has begun, done within 5 us. On a miss the next transfer is late, beyond 200 us given up
    /// and counted.
    #[task(binds = DMA2_STREAM0, priority = 6, shared = [imus])]
    fn imu_received(cx: imu_received::Context) {
        load::IMU_RECEIVED.measure(|| cx.shared.imus.received());
    }

    /// Every loop period; its pulses must be written within `board::PULSE_DELAY_US`. On a miss the pulses before are
    /// sent once more; a step that outlasts the period is counted, and without any the watchdog resets the board. In
    /// HITL the timer only beats for housekeeping, and each message makes a step.
    #[task(
        binds = TIM3, priority = 5,
        local = [control, outputs, loop_timer, trace, housekeeping_ticks, ticks: u32 = 0],
        shared = [sender, planning, plan, offer, slate, status, recorder]
    )]
    fn control_step(mut cx: control_step::Context) {
        let local = cx.local;
        let ticked = local.loop_timer.take_tick();
        let step = load::LOOP.measure(|| {
            local.control.consider(&mut cx.shared.offer, &mut cx.shared.planning);
            if !local.control.gather() {
                return None;
            }
            let output = local.control.fast(cx.shared.plan.lock(Option::take));
            if let Some(answer) = local.control.hil_answer(&output) {
                cx.shared.sender.lock(|sender| sender.send_first(answer));
            }
            local.outputs.write(output.compare_counts, local.control.motors_turn(&output));
            if let Some(request) = local.control.follow(&output) {
                watchdog::expect_plan();
                cx.shared.planning.lock(|planning| planning.ask(request));
            }
            cx.shared.slate.lock(|slate| local.control.teach(slate));
            local.trace.publish(local.control.input(), &output, local.control.state());
            if flight_log::is_wanted() {
                cx.shared.recorder.lock(|recorder| local.control.record(&output, recorder));
            }
            Some(output)
        });
        if let Some(output) = step {
            let step_status = local.control.status(&output);
            cx.shared.status.lock(|status| *status = step_status);
        }
        if ticked {
            if local.control.is_timed() {
                // a lost edge or a transfer that hangs is noticed once a step
                rtic::pend(Interrupt::EXTI0);
                if local.loop_timer.is_late() {
                    counters::LOOP_OVERRUNS.add();
                }
            }
            watchdog::report_loop();
            *local.ticks = local.ticks.wrapping_add(1);
            if local.ticks.is_multiple_of(*local.housekeeping_ticks) {
                // still busy with the one before: the watchdog notices if that lasts
                rtic::pend(Interrupt::CAN1_RX1);
            }
        }
        if local.control.has_more() {
            rtic::pend(Interrupt::TIM3);
        }
    }

    /// Every 5 ms, done within 10 us; on a miss the receiver's channels are that much older. What the chip has not
    /// answered is asked again.
    #[task(binds = SysTick, priority = 4, shared = [io])]
    fn io_slot(cx: io_slot::Context) {
        load::IO.measure(|| cx.shared.io.begin_slot());
    }

    /// When the chip has replied, done within 4 ms. On a miss the reply counts as lost.
    #[task(binds = USART6, priority = 4, shared = [io])]
    fn io_replied(cx: io_replied::Context) {
        load::IO.measure(|| cx.shared.io.line_is_idle());
    }

    /// When a message has arrived or the ring is half full, done within 22 ms. On a miss bytes are lost, and the CRC of
    /// their messages says so. Orders that find no room are lost; the ground repeats what is not answered.
    #[task(binds = USART2, priority = 3, shared = [link])]
    fn link_idle(mut cx: link_idle::Context) {
        load::LINK.measure(|| cx.shared.link.lock(LinkIn::take));
    }

    /// As [`link_idle`], when half of the ring is full.
    #[task(binds = DMA1_STREAM5, priority = 3, shared = [link])]
    fn link_ring(mut cx: link_ring::Context) {
        load::LINK.measure(|| cx.shared.link.lock(LinkIn::take));
    }

    /// When a transfer to the ground has ended: an answer that waited for it goes out, 3 bytes' time later at most.
    #[task(binds = DMA1_STREAM6, priority = 3, shared = [sender])]
    fn link_sent(mut cx: link_sent::Context) {
        load::LINK.measure(|| cx.shared.sender.lock(|sender| sender.transfer_ended()));
    }

    /// In MPC mode once a step, to be done before the next. On a miss that next step takes the cascade's torque, and
    /// its own request is not made.
    #[task(binds = CAN1_RX0, priority = 2, local = [mpc_state], shared = [planning, plan])]
    fn plan(mut cx: plan::Context) {
        let Some((request, mpc)) = cx.shared.planning.lock(Planning::begin) else { return };
        let (plan, duration_us) = load::PLAN.time(|| FlightCore::plan(&*mpc, cx.local.mpc_state, &request));
        let plan = Plan { duration_us, ..plan };
        watchdog::report_plan();
        // at once, so that a step between the two neither misses the plan nor finds its own request refused
        (cx.shared.planning, cx.shared.plan).lock(|planning, latest| *latest = Some(planning.done(mpc, plan)));
    }

    /// Every 10 ms, done within 20 ms of the last. On a miss the watchdog resets the board.
    #[task(
        binds = CAN1_RX1, priority = 1, shared = [link, sender, status, shelf, demand],
        local = [
            ground, usb, light_and_tone, watchdog, clock: TimeBase = TimeBase::START,
            load_meter: LoadMeter = LoadMeter::NEW, load_permille: u16 = 0, ticks: u32 = 0,
            self_tests: SelfTests = SelfTests::NEW,
        ]
    )]
    fn housekeeping(mut cx: housekeeping::Context) {
        let local = cx.local;
        local.watchdog.feed_if_all_alive();
        load::HOUSEKEEPING.measure(|| {
            *local.ticks = local.ticks.wrapping_add(1);
            let status = VehicleStatus {
                load_permille: *local.load_permille,
                overruns: counters::LOOP_OVERRUNS.get(),
                ..cx.shared.status.lock(|status| *status)
            };
            let (now_us, seen) = (local.clock.now_us(), cx.shared.link.lock(|link| link.seen()));
            let terms = local.ground.sign(seen, now_us);
            cx.shared.link.lock(|link| link.follow(&terms));
            let came = local.usb.look();
            let files_over_usb = cx.shared.link.lock(|link| {
                link.take_from_usb(&came);
                link.files_over_usb()
            });
            let usb = (local.usb, files_over_usb);
            cx.shared.shelf.lock(|shelf| local.ground.update((now_us, &status), shelf, usb));
            local.ground.bring_into_use((now_us, &status), &mut cx.shared.demand, &mut cx.shared.link);
            cx.shared.sender.lock(|sender| local.ground.hand_over(sender));
            local.self_tests.update(&status, || local.ground.memory_is_whole());
            if local.ticks.is_multiple_of(10) {
                local.light_and_tone.update(Sign::of(&status));
            }
            if local.ticks.is_multiple_of(100) {
                *local.load_permille = local.load_meter.permille();
                local.ground.figures(load::report(&status.planning, &status.motors));
                counters::report();
                local.self_tests.report();
            }
        });
    }

    /// At once, before anything else. There is no second chance if the supply is failing; a dip that is over before one
    /// could act on it is none.
    #[task(binds = PVD, priority = 7)]
    fn low_supply(_: low_supply::Context) {
        if supply::stays_low() {
            fault::stop(Cause::LowSupply, 0, 0);
        }
    }

    /// Writes the log, or makes what the loop is to take of parameters that were set, and sleeps until an interrupt. On
    /// a miss steps are left out of the log, and counted; parameters come into use later.
    #[idle(local = [workshop], shared = [recorder, shelf, status, demand, offer, slate])]
    fn idle(mut cx: idle::Context) -> ! {
        loop {
            let idle::SharedResources { recorder, shelf, status, demand, offer, slate, .. } = &mut cx.shared;
            cx.local.workshop.turn((recorder, shelf, status), (demand, offer, slate));
            load::sleep();
        }
    }
}
