//! Fitted gains that what follows from the stick or the reference alone surely denies.

use super::estimate::Estimate;
use crate::axis::Axis;
use crate::log::sanity::ByReference;

/// Both gains of each axis whose fitted one is denied, in words.
pub(super) fn denied<'r>(
    by_reference: impl IntoIterator<Item = &'r ByReference>,
    fitted: &[Option<Estimate>; 3],
) -> Vec<String> {
    let both = |of: &ByReference| {
        let axis = Axis::ALL.into_iter().find(|axis| axis.name() == of.axis)?;
        let gain = fitted[axis.index()]?;
        of.denies(gain.value, gain.std).then(|| format!("{of}, {gain} by all motion"))
    };
    by_reference.into_iter().filter_map(both).collect()
}
