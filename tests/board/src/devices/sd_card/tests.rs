//! The card by itself, as a host would lead it.

use super::*;

const MILLISECOND: Ticks = 1000 * TICKS_PER_US;
const HOST: u32 = HIGH_CAPACITY | 0x0010_0000;

fn card() -> SdCard {
    SdCard::new(Content::blank(65_536), Pauses { long_one_in: 0, ..Pauses::USUAL }, 1)
}

fn short(response: Response) -> u32 {
    match response {
        Response::Short(word) => word,
        other => panic!("{other:?}"),
    }
}

/// Up to the transfer state; its address in the upper half of a word.
fn selected(card: &mut SdCard) -> u32 {
    card.command(0, 0, 0);
    assert_eq!(card.command(8, 0x1aa, 0), Response::Short(0x1aa));
    short(card.command(55, 0, 0));
    assert_eq!(card.command(41, HOST, 0), Response::Conditions(VOLTAGES));
    short(card.command(55, 0, 0));
    let Response::Conditions(ready) = card.command(41, HOST, INITIALISATION) else { panic!() };
    assert_eq!(ready & (POWERED_UP | HIGH_CAPACITY), POWERED_UP | HIGH_CAPACITY);
    assert_eq!(card.command(2, 0, 0), Response::Long(CID));
    let address = short(card.command(3, 0, 0)) & 0xffff_0000;
    short(card.command(7, address, 0));
    address
}

fn state(card: &mut SdCard, address: u32, now: Ticks) -> u32 {
    short(card.command(13, address, now)) >> 9 & 0xf
}

#[test]
fn a_block_that_was_written_is_read_back_after_the_card_was_busy() {
    let mut card = card();
    let address = selected(&mut card);
    short(card.command(24, 77, 0));
    assert_eq!(state(&mut card, address, 0), State::ReceivingData as u32);
    let taken = card.receive_block(&[5; 512], 0).unwrap();
    assert_eq!(taken, BlockStatus::Taken { busy_until: Some(MILLISECOND) });
    assert_eq!(state(&mut card, address, MILLISECOND - 1), State::Programming as u32);
    assert_eq!(state(&mut card, address, MILLISECOND), State::Transfer as u32);
    short(card.command(17, 77, MILLISECOND));
    assert_eq!(card.sends(), Some((MILLISECOND + Pauses::USUAL.access, 512)));
    assert_eq!(card.send_block(0), [5; 512]);
    assert_eq!(card.content().writes(), [(77, [5; 512])]);
}

#[test]
fn blocks_follow_each_other_until_they_are_stopped() {
    let mut card = card();
    let address = selected(&mut card);
    short(card.command(25, 10, 0));
    for byte in [1, 2, 3] {
        card.receive_block(&[byte; 512], 0).unwrap();
        assert_eq!(state(&mut card, address, 0), State::ReceivingData as u32);
    }
    short(card.command(12, 0, 0));
    assert_eq!(state(&mut card, address, 0), State::Programming as u32);
    assert_eq!([9, 10, 11, 12, 13].map(|sector| card.content().read(sector)[0]), [0, 1, 2, 3, 0]);
    assert_eq!(card.receive_block(&[4; 512], 0), Err(BLOCK_UNAWAITED));
}

#[test]
fn what_is_illegal_is_not_answered_and_said_once() {
    let mut card = card();
    let address = selected(&mut card);
    assert_eq!(card.command(2, 0, 0), Response::None);
    assert_eq!(short(card.command(13, address, 0)) & ILLEGAL_COMMAND, ILLEGAL_COMMAND);
    assert_eq!(short(card.command(13, address, 0)) & ILLEGAL_COMMAND, 0);
    assert_eq!(short(card.command(17, 65_536, 0)) & OUT_OF_RANGE, OUT_OF_RANGE);
    // for somebody else
    assert_eq!(card.command(13, address ^ 1 << 16, 0), Response::None);
}

#[test]
fn a_host_that_knows_no_high_capacity_waits_for_ever() {
    let mut card = card();
    for now in [0, 2 * INITIALISATION] {
        card.command(55, 0, now);
        assert_eq!(card.command(41, 0x0010_0000, now), Response::Conditions(VOLTAGES));
    }
}

#[test]
fn faults_are_what_they_are_called() {
    let mut card = card();
    let address = selected(&mut card);
    card.set_fault(Some(CardFault::WriteError));
    short(card.command(24, 1, 0));
    card.receive_block(&[1; 512], 0).unwrap();
    assert_eq!(short(card.command(13, address, MILLISECOND)) & ERROR, ERROR);
    assert!(card.content().writes().is_empty());
    card.set_fault(Some(CardFault::BusyForEver));
    short(card.command(24, 1, MILLISECOND));
    assert_eq!(card.receive_block(&[1; 512], 0), Ok(BlockStatus::Taken { busy_until: None }));
    assert_eq!(state(&mut card, address, 1000 * TICKS_PER_S), State::Programming as u32);
    card.remove();
    assert_eq!(card.command(0, 0, 0), Response::None);
}

#[test]
fn a_card_that_is_not_identified_yet_wants_a_slow_clock() {
    let mut card = card();
    assert_eq!(card.check_clock(TICKS_PER_S / 400_000), Ok(()));
    assert_eq!(card.check_clock(TICKS_PER_S / 420_000), Err(CLOCK_TOO_FAST));
    selected(&mut card);
    assert_eq!(card.check_clock(TICKS_PER_S / 24_000_000), Ok(()));
    assert_eq!(card.check_clock(TICKS_PER_S / 48_000_000), Err(CLOCK_TOO_FAST));
}

#[test]
fn long_pauses_come_now_and_then_and_stay_within_what_is_allowed() {
    let mut clockwork = Clockwork::new(Pauses::USUAL, 3);
    let drawn: Vec<_> = (0..1000).map(|_| clockwork.after_write()).collect();
    let long = drawn.iter().filter(|pause| **pause > MILLISECOND).count();
    assert!((20..70).contains(&long), "{long}");
    assert!(drawn.iter().all(|pause| *pause == MILLISECOND || (100 * MILLISECOND..=250 * MILLISECOND).contains(pause)));
}
