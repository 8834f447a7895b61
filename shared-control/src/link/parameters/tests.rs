//! The service as a ground station and the memory of the board see it.

extern crate std;
use super::*;
use crate::link::{Answer, Chore, Commander, Guard, LinkSettings, Order, Receiver};
use crate::params::decode;
use crate::params::tests::any_params;
use crate::signals::ArmingBlocks;
use crate::supervisor::{Arming, Refusal};
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
    parameters.serve(request, |_| panic!("nothing is to be stored"))
}

proptest! {
    /// From one set of choices to any other, one field at a time over the link; what the memory holds after each is the
    /// record of it, and the last is the whole.
    #[test]
    fn every_field_makes_the_round_trip(from in any_params(), to in any_params()) {
        let mut parameters = Parameters::new(&from);
        let (mut expected, mut memory) = (from, [0; RECORD_LEN]);
        for field in Field::ALL {
            let name = field.row().name;
            let request = accepted(order_of(&set(name, number(&to, field))));
            let words = parameters.serve(&request, |record| {
                memory = *record;
                true
            });
            expected = expected.with(field, to.get(field)).unwrap();
            prop_assert_eq!(memory, encode(&expected));
            let words = words.unwrap();
            prop_assert_eq!(words.as_str(), std::format!("{name} stored for the next start"));
            let value = (name.to_string(), number(&to, field), field.index().into(), Field::ALL.len() as u16);
            prop_assert_eq!(told(&mut parameters), std::vec![value]);
        }
        prop_assert_eq!(decode(&memory), Ok(to));
    }

    /// Whatever number comes, only what the table allows is stored, and the answer is the value that then stands.
    #[test]
    fn no_value_gets_past_the_table(at in 0..Field::ALL.len(), bits: u32) {
        let field = Field::ALL[at];
        let value = f32::from_bits(bits);
        let mut parameters = Parameters::new(&Params::DEFAULT);
        let request = ParameterRequest::Set { field, value };
        parameters.serve(&request, |record| {
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
    let words = parameters.serve(&request, |_| false).unwrap();
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

#[test]
fn nothing_is_set_while_armed_or_before_a_bad_record_is_confirmed() {
    let order = order_of(&set("PULSES", 1.0));
    let refused = |because| (Some(Answer::ParameterRefused(Field::Pulses, because)), None);
    let mut armed = Commander::new(&LinkSettings::NOMINAL, ArmingBlocks::default());
    armed.answer(&Arming::Armed);
    assert_eq!(armed.order(&order, 0), refused(Refusal::Armed));
    // reading is always allowed
    let list = Order::Parameters(ParameterRequest::List);
    assert_eq!(armed.order(&list, 0), (None, Some(Chore::Parameters(ParameterRequest::List))));

    // one good field must not vouch for defaults that nobody has looked at
    let blocks = ArmingBlocks { configuration_unconfirmed: true, ..ArmingBlocks::default() };
    let mut unconfirmed = Commander::new(&LinkSettings::NOMINAL, blocks);
    assert_eq!(unconfirmed.order(&order, 0), refused(Refusal::ConfigurationUnconfirmed));
    unconfirmed.order(&Order::ConfirmConfiguration, 0);
    assert!(matches!(unconfirmed.order(&order, 0), (None, Some(Chore::Parameters(ParameterRequest::Set { .. })))));
}
