//! What to do about a refusal, found by its words.

use shared_control::supervisor::Refusal;

/// What each reason asks of the owner; reasons that say it themselves are not among them.
const ADVICE: [(Refusal, &str); 12] = [
    (Refusal::ThrottleNotZero, "put the throttle stick to its low end"),
    (Refusal::AttitudeUnknown, "keep the vehicle still until status says that the attitude is known"),
    (Refusal::GyroNotCalibrated, "put it down and leave it alone for some seconds"),
    (Refusal::BatteryLow, "charge it; BATT_ARM_MIN_MV is what arming needs"),
    (Refusal::ConfigurationUnconfirmed, "look through params, set what is wrong, then confirm"),
    (Refusal::FaultRecordUnread, "the board stopped once by a fault, told at its start: read it, then fault-read"),
    (
        Refusal::VehicleUnusable,
        "say whose numbers are flown: rig free f450, or set the VEH_ parameters and rig free own",
    ),
    (Refusal::RadioUnusable, "radio shows the sticks' pulses; set the RC_ parameters by them"),
    (Refusal::Armed, "disarm first"),
    (Refusal::NotLevel, "put it on something level"),
    (Refusal::BatteryUnmeasured, "connect the power module"),
    (Refusal::LinkLost, "wait a moment: this console has only just been heard"),
];

/// The words of a refusal in what the vehicle was heard to say.
pub(super) fn refusal_in(said: &str) -> Option<&str> {
    said.find("refused: ").and_then(|at| said.get(at..))
}

/// A refusal with what to do about it.
pub(super) fn explained(words: &str) -> String {
    match ADVICE.iter().find(|(refusal, _)| refusal.words() == words) {
        Some((_, advice)) => format!("{words} - {advice}"),
        None => words.to_owned(),
    }
}
