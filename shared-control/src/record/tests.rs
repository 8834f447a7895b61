//! The numbers are a format: a debugger reads them, and a trace of yesterday is compared with the code of today.

extern crate std;
use crate::flight_core::TorqueSource;
use crate::sensing::imu_health::{ImuFault, ImuHealth};
use crate::sensing::imu_select::ImuUnit;
use crate::signals::PlanStatus;
use crate::supervisor::{Arming, DisarmedBecause, EscStage, Refusal};
use std::collections::BTreeSet;
use std::vec::Vec;

/// Those that the cascade may fly for, and the one that it never does.
const STATUSES: [PlanStatus; 4] =
    [PlanStatus::Solved, PlanStatus::IterationLimit, PlanStatus::Infeasible, PlanStatus::NumericalError];

#[test]
fn units_healths_and_plans_count_from_nought() {
    assert_eq!([ImuUnit::First, ImuUnit::Second].map(|unit| unit.number()), [0, 1]);
    assert_eq!(ImuHealth::Good.number(), 0);
    assert_eq!(ImuFault::ALL.map(|fault| ImuHealth::Bad(fault).number()), [1, 2, 3, 4]);
    assert_eq!(STATUSES.map(|status| status.number()), [0, 1, 2, 3]);
    assert_eq!(STATUSES.map(|status| PlanStatus::of_number(status.number())), STATUSES);
    assert_eq!(PlanStatus::of_number(PlanStatus::Curtailed.number()), PlanStatus::Curtailed);
    assert_eq!((PlanStatus::Curtailed.number(), PlanStatus::of_number(5)), (4, PlanStatus::NumericalError));
    let armings = [
        Arming::Armed,
        Arming::default(),
        Arming::MotorTest { motor: 1, throttle_percent: 2, until_us: 3 },
        Arming::LinkLost { since_us: 4 },
        Arming::EscCalibration { stage: EscStage::Low, since_us: 5 },
        Arming::BatteryLow { since_us: 6 },
    ];
    assert_eq!(armings.map(|arming| arming.number()), [0, 1, 2, 3, 4, 5]);
}

#[test]
fn every_source_of_torque_has_its_number() {
    let without_status = [
        TorqueSource::Disarmed,
        TorqueSource::Cascade,
        TorqueSource::Mpc,
        TorqueSource::CascadeNoPlan,
        TorqueSource::MotorTest,
        TorqueSource::Idle,
        TorqueSource::EscCalibration,
        TorqueSource::ReducedAttitude,
    ];
    assert_eq!(without_status.map(|source| source.number()), [0, 1, 2, 3, 4, 9, 10, 11]);
    assert_eq!(STATUSES.map(|status| TorqueSource::CascadeUnsolved(status).number()), [5, 6, 7, 8]);
}

/// Groups are apart: causes below 0x10, an IMU's faults from 0x10, refusals from 0x100, for an IMU's fault from 0x120.
#[test]
fn every_reason_to_stand_still_has_its_number() {
    let causes = [
        DisarmedBecause::Start,
        DisarmedBecause::Requested,
        DisarmedBecause::AttitudeUnknown,
        DisarmedBecause::LinkLost,
        DisarmedBecause::MotorTestOver,
        DisarmedBecause::Crashed,
        DisarmedBecause::EscsCalibrated,
        DisarmedBecause::EscCalibrationEnded,
        DisarmedBecause::Killed,
        DisarmedBecause::BatteryLow,
        DisarmedBecause::MotorLost,
    ];
    assert_eq!(causes.map(|because| because.number()), [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10]);
    assert_eq!(ImuFault::ALL.map(|fault| DisarmedBecause::ImuFailed(fault).number()), [0x10, 0x11, 0x12, 0x13]);
    let refused = |refusal| DisarmedBecause::Refused(refusal).number();
    assert!(Refusal::WITHOUT_DETAIL.map(refused).into_iter().eq(0x100..0x11E));
    assert_eq!(ImuFault::ALL.map(|fault| refused(Refusal::ImuUnhealthy(fault))), [0x120, 0x121, 0x122, 0x123]);
    let all: Vec<u32> = causes
        .into_iter()
        .chain(ImuFault::ALL.map(DisarmedBecause::ImuFailed))
        .chain(Refusal::WITHOUT_DETAIL.map(DisarmedBecause::Refused))
        .map(|because| because.number())
        .collect();
    assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), all.len());
}

/// What a state remembers of its arming: kind, detail, and the time low word first.
#[test]
fn an_arming_state_is_four_words() {
    use crate::record::state_words::StateWords;
    let words = |arming: Arming| {
        let mut words = StateWords::EMPTY;
        arming.record(&mut words);
        assert_eq!(words.written, 4);
        [words.words[0], words.words[1], words.words[2], words.words[3]]
    };
    let test = Arming::MotorTest { motor: 3, throttle_percent: 25, until_us: 0x7_0000_0009 };
    assert_eq!(words(test), [2, 0x0319, 9, 7]);
    assert_eq!(words(Arming::LinkLost { since_us: 11 }), [3, 0, 11, 0]);
    assert_eq!(words(Arming::EscCalibration { stage: EscStage::Low, since_us: 12 }), [4, 2, 12, 0]);
    assert_eq!(words(Arming::Disarmed(DisarmedBecause::Requested)), [1, 1, 0, 0]);
    assert_eq!(words(Arming::Armed), [0; 4]);
}
