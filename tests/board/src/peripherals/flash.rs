//! Flash interface. RM0090 section 3.9. What the access control costs is [`super::flash_timing`]'s; programming has no
//! model.

use super::flash_timing::AccessControl;
use super::{Peripheral, Unmodelled};
use crate::time::Ticks;

#[derive(Clone, Debug, Default)]
pub(crate) struct Flash {
    access_control: u32,
}

impl Flash {
    /// Wait states, prefetch, caches.
    pub(crate) fn access_control(&self) -> AccessControl {
        AccessControl(self.access_control)
    }
}

impl Peripheral for Flash {
    fn read(&mut self, offset: u32, _: Ticks) -> Result<u32, Unmodelled> {
        match offset {
            0x0 => Ok(self.access_control),
            _ => Err(Unmodelled("flash programming")),
        }
    }

    fn write(&mut self, offset: u32, value: u32, _: Ticks) -> Result<(), Unmodelled> {
        match offset {
            0x0 => self.access_control = value,
            _ => return Err(Unmodelled("flash programming")),
        }
        Ok(())
    }
}
