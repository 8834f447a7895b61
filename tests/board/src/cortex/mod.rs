//! What ARM puts around the core: exceptions (NVIC), system control, SysTick, cycle counter. ARMv7-M ARM, part B.

pub(crate) mod cycles;
pub(crate) mod exceptions;
pub(crate) mod private_bus;
pub(crate) mod stacking;
pub(crate) mod systick;
