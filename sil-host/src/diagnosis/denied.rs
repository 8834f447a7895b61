//! Fitted gains that what follows from the stick or the reference alone surely denies.

use super::estimate::Estimate;
use crate::log::sanity::ByReference;

/// Both gains of each axis whose fitted one is denied, in words; the fitted one is asked for by the axis' name.
pub(super) fn denied<'r>(
    by_reference: impl IntoIterator<Item = &'r ByReference>,
    fitted: impl Fn(&str) -> Option<Estimate>,
) -> Vec<String> {
    let both = |of: &ByReference| {
        let gain = fitted(of.axis)?;
        of.denies(gain.value, gain.std).then(|| format!("{of}, {gain} by all motion"))
    };
    by_reference.into_iter().filter_map(both).collect()
}
