//! The service as a ground station and the memory of the board see it.

extern crate std;
use super::*;
use crate::link::{Answer, Chore, Commander, Guard, LinkSettings, Order, Receiver};
use crate::params::decode;
use crate::params::tests::any_params;
use crate::signals::ArmingBlocks;
use crate::supervisor::Refusal;
use mavlink::MessageData;
use mavlink::dialects::common::{MavMessage, PARAM_REQUEST_LIST_DATA, PARAM_REQUEST_READ_DATA, PARAM_SET_DATA};
use mavlink::{MAVLinkV2MessageRaw, MavlinkVersion, Message};
use proptest::prelude::*;
use std::string::ToString;
use std::vec::Vec;

/// The one order that a message makes.
fn order_of(data: &impl MessageData) -> Order {
    let mut bytes = heapless::Vec::<u8, 100>::new();
    assert!(FrameWriter::new(255, 190).write(data, &mut bytes));
    let mut receiver = Receiver::new(LinkSettings::NOMINAL);
    let orders: Vec<_> = bytes.iter().filter_map(|byte| receiver.receive(*byte, &mut Guard::open())).collect();
    assert_eq!(orders.len(), 1, "{orders:?}");
    orders[0]
}

/// A field as it goes over the link.
fn number(params: &Params, field: Field) -> f32 {
    field.row().allowed.number(params.get(field)) as f32
}

fn set(name: &str, value: f32) -> PARAM_SET_DATA {
    PARAM_SET_DATA {
        param_value: value,
        target_system: 1,
        target_component: 1,
        param_id: name.into(),
        param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
    }
}

/// The request of an order, as a disarmed vehicle with a good configuration takes it.
fn accepted(order: Order) -> ParameterRequest {
    let mut commander = Commander::new(&LinkSettings::NOMINAL, ArmingBlocks::default());
    let (None, Some(Chore::Parameters(request))) = commander.order(&order, 0) else { panic!("{order:?}") };
    request
}

/// All values that are due, as the `mavlink` crate reads them: name, value, index, count.
fn told(parameters: &mut Parameters) -> Vec<(std::string::String, f32, u16, u16)> {
    let mut writer = FrameWriter::new(1, 1);
    let mut values = Vec::new();
    loop {
        let mut out = heapless::Vec::<u8, 64>::new();
        parameters.write_next(&mut writer, &mut out);
        if out.is_empty() {
            return values;
        }
        let mut raw = MAVLinkV2MessageRaw::new();
        raw.as_mut_slice()[..out.len()].copy_from_slice(&out);
        assert!(raw.has_valid_crc::<MavMessage>());
        let Ok(MavMessage::PARAM_VALUE(value)) = MavMessage::parse(MavlinkVersion::V2, raw.message_id(), raw.payload())
        else {
            panic!("not a PARAM_VALUE");
        };
        assert_eq!(value.param_type, MavParamType::MAV_PARAM_TYPE_REAL32);
        values.push((
            value.param_id.to_str().unwrap().to_string(),
            value.param_value,
            value.param_index,
            value.param_count,
        ));
    }
}

/// Serves with a memory that must not be touched.
fn serve_without_storing(parameters: &mut Parameters, request: &ParameterRequest) -> Option<Text> {
    parameters.serve(request, false, |_| panic!("nothing is to be stored"))
}

proptest! {
    /// From one set of choices to any other, one field at a time over the link; what the memory holds after each is the
    /// record of it, and the last is the whole. Nothing arms until what counts at once is in use.
    #[test]
    fn every_field_makes_the_round_trip(from in any_params(), to in any_params()) {
        let mut parameters = Parameters::new(&from);
        let (mut expected, mut memory) = (from, [0; RECORD_LEN]);
        for field in Field::ALL {
            let name = field.row().name;
            let request = accepted(order_of(&set(name, number(&to, field))));
            let words = parameters.serve(&request, false, |record| {
                memory = *record;
                true
            });
            expected = expected.with(field, to.get(field)).unwrap();
            prop_assert_eq!(memory, encode(&expected));
            let said = match (field.counts(), to.get(field) == from.get(field)) {
                (Counts::NextStart, _) => Some(std::format!("{name} stored for the next start")),
                (Counts::AtOnce, true) => Some(std::format!("{name} in use now")),
                (Counts::AtOnce, false) => None,
            };
            prop_assert_eq!(words.as_deref(), said.as_deref());
            let value = (name.to_string(), number(&to, field), field.index().into(), Field::ALL.len() as u16);
            prop_assert_eq!(told(&mut parameters), std::vec![value]);
        }
        prop_assert_eq!(decode(&memory), Ok(to));
        let wanted = parameters.wanted().copied();
        prop_assert_eq!(wanted.unwrap_or(from), from.with_what_counts_of(&to));
        let changes = Field::ALL.len() as u8;
        prop_assert_eq!(parameters.settled(false) == changes, wanted.is_none());
        if let Some(wanted) = wanted {
            parameters.now_in_use(&wanted);
        }
        prop_assert_eq!(parameters.wanted(), None);
        prop_assert_eq!(parameters.settled(false), changes);
    }

    /// Whatever number comes, only what the table allows is stored, and the answer is the value that then stands.
    #[test]
    fn no_value_gets_past_the_table(at in 0..Field::ALL.len(), bits: u32) {
        let field = Field::ALL[at];
        let value = f32::from_bits(bits);
        let mut parameters = Parameters::new(&Params::DEFAULT);
        let request = ParameterRequest::Set { field, value };
        parameters.serve(&request, false, |record| {
            assert!(decode(record).is_ok_and(|params| number(&params, field) == value));
            true
        });
        let stands = number(&parameters.stored, field);
        prop_assert_eq!(told(&mut parameters)[0].1, stands);
    }
}

#[test]
fn a_list_tells_all_and_a_read_tells_one() {
    let mut parameters = Parameters::new(&Params::DEFAULT);
    let to_us = |param_index: i16, name: &str| PARAM_REQUEST_READ_DATA {
        param_index,
        target_system: 1,
        target_component: 1,
        param_id: name.into(),
    };
    let list = accepted(order_of(&PARAM_REQUEST_LIST_DATA { target_system: 1, target_component: 0 }));
    assert_eq!(serve_without_storing(&mut parameters, &list), None);
    let all = told(&mut parameters);
    assert_eq!(all.len(), Field::ALL.len());
    for (index, (field, (name, value, told_index, count))) in Field::ALL.into_iter().zip(all).enumerate() {
        assert_eq!((name.as_str(), usize::from(told_index), count), (field.row().name, index, Field::ALL.len() as u16));
        assert_eq!(value, number(&Params::DEFAULT, field));
        let by_name = accepted(order_of(&to_us(-1, &name)));
        let by_index = accepted(order_of(&to_us(index as i16, "")));
        assert_eq!((by_name, by_index), (ParameterRequest::Read(field), ParameterRequest::Read(field)));
        serve_without_storing(&mut parameters, &by_name);
        assert_eq!(told(&mut parameters).len(), 1);
    }
    for (index, name) in
        [(-1, "PWM_RATE"), (Field::ALL.len() as i16, "PWM_RATE_HZ"), (i16::MAX, ""), (-1, "PWM_RATE_HZ_LONG")]
    {
        assert_eq!(accepted(order_of(&to_us(index, name))), ParameterRequest::Unknown, "{index} {name}");
    }
}

#[test]
fn what_cannot_be_is_refused_in_words_and_answered_with_what_stands() {
    let bad = [
        ("LOOP_RATE_HZ", 250.0, "bad LOOP_RATE_HZ: 100 or 400"),
        ("PWM_RATE_HZ", 491.0, "bad PWM_RATE_HZ: 50 to 490"),
        ("PWM_RATE_HZ", 400.5, "bad PWM_RATE_HZ: 50 to 490"),
        ("CONTROL_HORIZON", f32::NAN, "bad CONTROL_HORIZON: 1 to 30"),
        ("CONTROL_HORIZON", 261.0, "bad CONTROL_HORIZON: 1 to 30"),
        ("BATT_ARM_MIN_MV", 65_536.0, "bad BATT_ARM_MIN_MV: 0 to 65535"),
        ("RIG", -1.0, "bad RIG: 0 or 1"),
    ];
    for (name, value, words) in bad {
        let mut parameters = Parameters::new(&Params::DEFAULT);
        let request = accepted(order_of(&set(name, value)));
        assert_eq!(serve_without_storing(&mut parameters, &request).unwrap().as_str(), words);
        let field = Field::by_name(name.as_bytes()).unwrap();
        assert_eq!(told(&mut parameters)[0].1, number(&Params::DEFAULT, field));
    }
    let of_another_type = PARAM_SET_DATA { param_type: MavParamType::MAV_PARAM_TYPE_UINT16, ..set("HIL", 1.0) };
    let mut parameters = Parameters::new(&Params::DEFAULT);
    let words = serve_without_storing(&mut parameters, &accepted(order_of(&of_another_type)));
    assert_eq!(words.unwrap().as_str(), "bad HIL: 0 or 1");
    let unknown = accepted(order_of(&set("NO_SUCH_THING", 1.0)));
    assert_eq!(serve_without_storing(&mut parameters, &unknown).unwrap().as_str(), "no such parameter");
}

#[test]
fn a_memory_that_fails_leaves_the_value_that_stands() {
    let mut parameters = Parameters::new(&Params::DEFAULT);
    let request = ParameterRequest::Set { field: Field::ControlHorizon, value: 7.0 };
    let words = parameters.serve(&request, false, |_| false).unwrap();
    assert_eq!(words.as_str(), "CONTROL_HORIZON not stored: memory failed");
    assert_eq!(told(&mut parameters)[0].1, 5.0);
    let mut memory = [0; RECORD_LEN];
    let stored = parameters.store(|record| {
        memory = *record;
        true
    });
    assert!(stored && decode(&memory) == Ok(Params::DEFAULT));
    assert!(!parameters.store(|_| false));
}

/// Sets a field and keeps it; what is said of it at once.
fn kept(parameters: &mut Parameters, field: Field, value: f32, is_armed: bool) -> Option<Text> {
    parameters.serve(&ParameterRequest::Set { field, value }, is_armed, |_| true)
}

#[test]
fn what_is_set_on_the_ground_is_said_when_it_is_in_use() {
    let mut parameters = Parameters::new(&Params::DEFAULT);
    let now_in_use = |parameters: &mut Parameters| {
        let wanted = *parameters.wanted().unwrap();
        parameters.now_in_use(&wanted)
    };
    assert_eq!(kept(&mut parameters, Field::FlightIdle, 12.0, false), None);
    assert_eq!(parameters.settled(false), 0, "arming waits");
    assert_eq!(now_in_use(&mut parameters).as_str(), "MOT_SPIN_MIN_PCT in use now");
    assert_eq!((parameters.settled(false), parameters.wanted()), (1, None));
    assert_eq!(kept(&mut parameters, Field::FlightIdle, 13.0, false), None);
    assert_eq!(kept(&mut parameters, Field::ControlHorizon, 7.0, false), None);
    // one more comes while these are being made
    let being_made = *parameters.wanted().unwrap();
    assert_eq!(kept(&mut parameters, Field::GroundIdle, 9.0, false), None);
    assert_eq!(parameters.now_in_use(&being_made).as_str(), "2 parameters in use now");
    assert_eq!(parameters.settled(false), 1, "the last is still waited for");
    assert_eq!(now_in_use(&mut parameters).as_str(), "MOT_SPIN_ARM_PCT in use now");
    assert_eq!(parameters.settled(false), 4);
    // there and back again before anybody looked: nothing is to be made
    assert_eq!(kept(&mut parameters, Field::ControlHorizon, 8.0, false), None);
    assert_eq!(kept(&mut parameters, Field::ControlHorizon, 7.0, false).unwrap(), "CONTROL_HORIZON in use now");
    assert_eq!((parameters.settled(false), parameters.wanted()), (6, None));
}

#[test]
fn what_is_set_in_the_air_waits_and_nobody_waits_for_it() {
    let mut parameters = Parameters::new(&Params::DEFAULT);
    let words = kept(&mut parameters, Field::ControlHorizon, 7.0, true).unwrap();
    assert_eq!(words.as_str(), "CONTROL_HORIZON stored; counts after disarming");
    let words = kept(&mut parameters, Field::LoopRate, 100.0, true).unwrap();
    assert_eq!(words.as_str(), "LOOP_RATE_HZ stored for the next start");
    // whoever has to start again at once can
    assert_eq!([true, false].map(|is_armed| parameters.settled(is_armed)), [2, 2]);
    assert_eq!(parameters.wanted(), Some(&Params { control_horizon: 7, ..Params::DEFAULT }));
    for field in Field::ALL {
        let longest = std::format!("{} stored; counts after disarming", field.row().name);
        assert!(longest.len() <= 50, "{longest}");
    }
}

/// A file of parameters goes in as a whole.
#[test]
fn what_is_set_waits_for_the_last_of_it() {
    let mut parameters = Parameters::new(&Params::DEFAULT);
    for change in 0..5_u8 {
        kept(&mut parameters, Field::ControlHorizon, 7.0 + f32::from(change), false);
        for passed_us in [0, 90_000] {
            assert_eq!(parameters.wanted_once_quiet(u64::from(change) * 100_000 + passed_us), None);
        }
    }
    assert_eq!(parameters.wanted_once_quiet(400_000 + QUIET_US - 1), None);
    let wanted = parameters.wanted_once_quiet(400_000 + QUIET_US).map(|wanted| wanted.control_horizon);
    assert_eq!(wanted, Some(11));
}

/// No record is known to hold such; a board would go on as it is, and say so.
#[test]
fn what_cannot_be_flown_is_not_wanted_again() {
    let mut parameters = Parameters::new(&Params::DEFAULT);
    kept(&mut parameters, Field::ControlHorizon, 7.0, false);
    parameters.not_usable();
    assert_eq!((parameters.settled(false), parameters.wanted()), (1, None));
}

#[test]
fn nothing_is_set_before_a_bad_record_is_confirmed() {
    let order = order_of(&set("PULSES", 1.0));
    let refused = |because| (Some(Answer::ParameterRefused(Field::Pulses, because)), None);
    // one good field must not vouch for defaults that nobody has looked at
    let blocks = ArmingBlocks { configuration_unconfirmed: true, ..ArmingBlocks::default() };
    let mut unconfirmed = Commander::new(&LinkSettings::NOMINAL, blocks);
    assert_eq!(unconfirmed.order(&order, 0), refused(Refusal::ConfigurationUnconfirmed));
    unconfirmed.order(&Order::ConfirmConfiguration, 0);
    assert!(matches!(unconfirmed.order(&order, 0), (None, Some(Chore::Parameters(ParameterRequest::Set { .. })))));
}
