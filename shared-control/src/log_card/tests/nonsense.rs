//! Cards whose content makes no sense, or that fail: an error, and never a panic or a search without end.

extern crate std;

use fatfs::FatType;
use proptest::prelude::*;

use super::{Memory, stream};
use crate::log_card::{CardError, CardLog};

std::thread_local! {
    static WHOLE: Memory = Memory::formatted(FatType::Fat16, 17, 0);
}

fn try_a_log(card: &mut Memory) -> Result<(), CardError> {
    let mut log = CardLog::mount(card)?;
    log.begin(card, 0)?;
    log.append(card, &stream(20_000))?;
    log.flush(card, 1)?;
    log.append(card, &stream(9_000))?;
    log.end(card, 2)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Bytes of the boot sector, of the FAT and of the root directory are turned.
    #[test]
    fn a_spoiled_file_system_is_an_error_or_a_log(
        turned in proptest::collection::vec((0..4_usize, 0..1024_usize, any::<u8>()), 1..12),
    ) {
        let mut card = WHOLE.with(Memory::clone);
        for (place, at, byte) in turned {
            let start = [0, 512, 2048, 8192][place];
            card.bytes[start + at] = byte;
        }
        let _ = try_a_log(&mut card);
    }
}

#[test]
fn a_card_that_fails_at_any_write_ends_the_log_in_words() {
    let mut whole = Memory::formatted(FatType::Fat32, 40, 0);
    let mut card = whole.clone();
    try_a_log(&mut card).unwrap();
    for writes in 0..card.writes.len() {
        whole.writes_left = writes;
        let mut card = whole.clone();
        assert_eq!(try_a_log(&mut card), Err(CardError::Failed), "after {writes} writes");
    }
}

#[test]
fn words_fit_into_a_status_text() {
    use CardError::{Absent, Damaged, Failed, Full, NoName, UnknownFormat};
    for error in [Absent, Failed, UnknownFormat, Damaged, Full, NoName] {
        assert!(error.words().len() <= 50, "{error:?}");
    }
}
