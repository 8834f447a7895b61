//! x
use sil_host::diagnosis::{Observer,Effort};
use sil_host::answer::{Answered, HeldAgainst, Said, json};
use sil_host::log::Wanted;
/// x
pub fn answer(request: &[u8], files: Vec<Vec<u8>>, observer: Observer<'_>) -> String {
    let _ = request;
    let log = Wanted::default().read("rig-log.csv".as_ref(), &mut &files[0][..]).unwrap();
    let against = HeldAgainst::of(&log, &Said::default(), &[], None).unwrap();
    let answered = Answered::of(log, against, Effort::Usual, observer).unwrap();
    let page = answered.page("dropped here").to_html();
    json(&answered.diagnosis).unwrap()+&page
}
