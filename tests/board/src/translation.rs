//! How the CPU emulator finds memory: every address is its own, and few pages are code.
//!
//! Where code may run, the emulator looks at each store whether it hits code that it has translated, and by the core's
//! own map that is all of RAM and CCM. So none of RAM is code until some of it is fetched, and CCM never is.

use unicorn_engine::{MemType, Prot, RegisterARM, TlbEntry, TlbType, Unicorn, uc_error};

use crate::memory::{self, Region};

/// EPSR: Thumb, and not within an IT block.
const OUTSIDE_OF_IT: u64 = 1 << 24;

/// The emulator asks here for each page that it has not at hand.
pub(crate) fn install(engine: &mut Unicorn<'static, ()>) -> Result<(), uc_error> {
    engine.ctl_set_tlb_type(TlbType::VIRTUAL)?;
    let mut runs_from_ram = false;
    engine.add_tlb_hook(1, 0, move |engine, address, kind| {
        let is_fetched = kind == MemType::FETCH;
        if !is_fetched {
            // It has set the state of the instruction that loads or stores, whose IT block the next block of code would
            // go on with. The code that runs knows its own, and leaves none there.
            engine.reg_write(RegisterARM::EPSR, OUTSIDE_OF_IT).ok()?;
        }
        let is_in = |region: Region| region.contains(address as u32, 1);
        runs_from_ram |= is_fetched && is_in(memory::RAM);
        let is_data = is_in(memory::CCM) && !is_fetched || is_in(memory::RAM) && !runs_from_ram;
        Some(TlbEntry { paddr: address, perms: if is_data { Prot::READ | Prot::WRITE } else { Prot::ALL } })
    })?;
    Ok(())
}
