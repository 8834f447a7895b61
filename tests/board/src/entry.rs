//! In what state the image finds chip and core when it starts: whoever jumped to it left something behind.

use unicorn_engine::RegisterARM as Register;

use crate::cpu::Cpu;

/// Who started the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EntryState {
    /// Nobody: everything as after reset, which a debug probe can do.
    #[default]
    Reset,
    /// PX4's bootloader (PX4-Bootloader, main_f4.c: `board_deinit`, `clock_deinit`, then the jump): back on HSI, but
    /// with five wait states, caches, floating point and VTOR set, the reload value still in SysTick.
    Px4Bootloader,
    /// ArduPilot's (AP_Bootloader, `jump_to_app`, on ChibiOS): PRIMASK set, BASEPRI raised, thread mode on the process
    /// stack, 168 MHz from the PLL, ports clocked, sensors already powered. SysTick, PendSV and interrupts are left
    /// enabled and pending, which is more than it is known to do.
    ArdupilotBootloader,
}

const FLASH_ACR: u32 = 0x4002_3c00;
const RCC_CR: u32 = 0x4002_3800;
const RCC_PLLCFGR: u32 = 0x4002_3804;
const RCC_CFGR: u32 = 0x4002_3808;
const RCC_AHB1ENR: u32 = 0x4002_3830;
const GPIOC: u32 = 0x4002_0800;
const GPIOE: u32 = 0x4002_1000;
const VTOR: u32 = 0xe000_ed08;
const CPACR: u32 = 0xe000_ed88;
const ICSR: u32 = 0xe000_ed04;
const SYST_CSR: u32 = 0xe000_e010;
const SYST_RVR: u32 = 0xe000_e014;
/// NVIC: set-enable, set-pending, priorities.
const ISER: u32 = 0xe000_e100;
const ISPR: u32 = 0xe000_e200;
const IPR: u32 = 0xe000_e400;

const FULL_FLOAT: (u32, u32) = (CPACR, 0xf << 20);

const PX4: [(u32, u32); 4] = [(FLASH_ACR, 0x605), FULL_FLOAT, (SYST_RVR, 167_999), (RCC_AHB1ENR, 0x0010_0000)];

const ARDUPILOT: [(u32, u32); 17] = [
    // HSE and PLL on; 24 MHz / 24 * 336 / 2; buses divided by 4 and 2
    (RCC_CR, 1 | 1 << 16 | 1 << 24),
    (RCC_PLLCFGR, 7 << 24 | 1 << 22 | 336 << 6 | 24),
    (FLASH_ACR, 0x705),
    (RCC_CFGR, 5 << 10 | 4 << 13 | 2),
    FULL_FLOAT,
    // all ports, CCM
    (RCC_AHB1ENR, 0x0010_01ff),
    // sensors on, chip selects high
    (GPIOE + 0x14, 1 << 3),
    (GPIOE, 1 << 6),
    (GPIOC + 0x14, 1 << 2 | 1 << 13 | 1 << 15),
    (GPIOC, 1 << 4 | 1 << 26 | 1 << 30),
    // SysTick at 1 kHz and pending, PendSV pending
    (SYST_RVR, 167_999),
    (SYST_CSR, 0b111),
    (ICSR, 1 << 28 | 1 << 26),
    // USART2, TIM5 and OTG_FS enabled, at these priorities, and pending
    (ISER + 4, 1 << (38 - 32) | 1 << (50 - 32)),
    (ISER + 8, 1 << (67 - 64)),
    (IPR + 36, 0x00c0_0000),
    (ISPR + 4, 1 << (38 - 32) | 1 << (50 - 32)),
];

impl EntryState {
    /// Registers that are not as after reset, in this order; the image's vectors lie at `vectors`.
    pub(crate) fn registers(self, vectors: u32) -> Vec<(u32, u32)> {
        let left_behind: &[_] = match self {
            EntryState::Reset => return Vec::new(),
            EntryState::Px4Bootloader => &PX4,
            EntryState::ArdupilotBootloader => &ARDUPILOT,
        };
        left_behind.iter().copied().chain([(VTOR, vectors)]).collect()
    }

    /// The core's own registers.
    pub(crate) fn prepare(self, cpu: &mut Cpu) {
        const PROCESS_STACK: u32 = 1 << 1;
        const FLOATS_IN_USE: u32 = 1 << 2;
        if self == EntryState::ArdupilotBootloader {
            cpu.set_register(Register::PRIMASK, 1);
            cpu.set_register(Register::BASEPRI, 0x20);
            cpu.set_register(Register::CONTROL, PROCESS_STACK | FLOATS_IN_USE);
            cpu.set_register(Register::PSP, 0x2000_0400);
        }
    }
}
