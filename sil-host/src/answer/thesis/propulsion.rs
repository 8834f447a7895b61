//! Chapter 3 and appendix C on the page: the constants and the curves that they make.

use crate::model::{Rig, VehicleModel};
use crate::refinement::{Found, Given, checks};
use crate::report::{Cell, Chart, Section, Table};
use crate::statistics::decimals;
use crate::thesis::Reproduction;
use crate::thesis::printed::device;
use crate::vehicle::propulsion::DevicePropulsion;

/// Points of a drawn curve.
const CURVE_POINTS: usize = 101;
/// Up to where curves over the speed are drawn, rad/s: what the thesis' motors reach.
const SPEED_MAX_RAD_S: f64 = 1200.0;
const VOLTAGE_MAX_V: f64 = 20.0;
/// What an F450 of the time was sold with (DJI's manual): propellers of 10 inches, motors of 920 rpm/V, three cells,
/// and a mass at take-off of about 1.2 kg.
const SOLD_WITH: Given =
    Given { diameter_m: Some(0.254), mass_kg: Some(1.2), kv_rpm_v: Some(920.0), supply_v: Some(12.6) };

/// Tables 3.3, 3.4, C.1 to C.3.
pub fn constants(of: &Reproduction) -> Section {
    let mut table = Table::new(
        "Tables 3.3, 3.4, C.1 to C.3",
        &["table", "symbol", "what it is", "unit", "printed", "testbed model", "free-flight model"],
    );
    for constant in &of.constants {
        let numbers = [Some(constant.printed), Some(constant.testbed), constant.free_flight];
        let words = [constant.table, constant.symbol, constant.meaning, constant.unit].map(Cell::from);
        table = table.row(words.into_iter().chain(numbers.map(number)));
    }
    Section::new("Chapter 3 and appendix C: the constants").table(table).note(
        "Table 3.4's products of inertia are a two-thousandth of the moments and left out. I_zz plays no part: yaw is \
         locked. Rows without a number in free flight: that vehicle's speed controller is a duty cycle of its battery.",
    )
}

fn number(value: Option<f64>) -> Cell {
    Cell::from(value.map_or("-".to_owned(), |value| match value.abs() {
        size if size >= 1e-2 => format!("{value:.*}", decimals(value, 5, 6)),
        _ => format!("{value:.4e}"),
    }))
}

/// Figures C.2 to C.7.
pub fn curves() -> Section {
    let (testbed, free) = (VehicleModel::nominal(Rig::Gimbal), VehicleModel::nominal(Rig::Free));
    let section = Section::new("Figures C.2 to C.7");
    let (Some(testbed), Some(free)) = (device(&testbed), device(&free)) else { return section };
    let speed = |title: &str, unit: &str, of: fn(&DevicePropulsion, f64) -> f64| {
        both(Chart::over("speed, rad/s", title, unit), [testbed, free], SPEED_MAX_RAD_S, of)
    };
    let line = |of: &DevicePropulsion, voltage_v: f64| of.speed_constant_rad_s_v * voltage_v + of.speed_offset_rad_s;
    let charts = [
        both(Chart::over("command, %", "C.2: speed controller", "V"), [testbed, free], 100.0, |of, percent| {
            of.voltage_v(0.01 * percent)
        }),
        both(Chart::over("voltage, V", "C.3: motor", "rad/s"), [testbed, free], VOLTAGE_MAX_V, line),
        speed("C.4: motor loss", "mN m", |of, speed| 1e3 * of.loss_nm_s * speed),
        speed("C.5: lift", "N", |of, speed| of.lift_n(speed)),
        speed("C.6: reaction torque", "mN m", |of, speed| 1e3 * of.reaction_torque_nm_s2 * speed * speed),
        speed("C.7: aerodynamic drag", "mN m", |of, speed| 1e3 * of.drag_nm_s2 * speed * speed),
    ];
    section
        .paragraph(
            "Drawn from the printed coefficients, beside those of the F450 that flies free, whose numbers have other \
             sources (models/f450-free.toml). `sil refine` makes such numbers from a bench's readings, each with its \
             interval.",
        )
        .side_by_side("Propulsion", charts)
}

fn both(chart: Chart, of: [&DevicePropulsion; 2], end: f64, curve: impl Fn(&DevicePropulsion, f64) -> f64) -> Chart {
    let over: Vec<f64> = (0..CURVE_POINTS).map(|point| end * point as f64 / (CURVE_POINTS - 1) as f64).collect();
    ["thesis", "free flight"].into_iter().zip(of).fold(chart, |chart, (name, device)| {
        let values: Vec<f64> = over.iter().map(|at| curve(device, *at)).collect();
        chart.series(name, &over, &values)
    })
}

/// What the printed constants contradict.
pub fn contradictions() -> Section {
    let testbed = VehicleModel::nominal(Rig::Gimbal);
    let section = Section::new("What cannot be");
    let Some(device) = device(&testbed) else { return section };
    let checks = checks(device, &SOLD_WITH, testbed.gravity_m_s2);
    let mut table = Table::new("Constants held against each other and against physics", &["check", "what it finds"]);
    for check in checks.iter().filter(|check| check.found == Found::Impossible) {
        table = table.row([check.name, check.says.as_str()].map(Cell::from));
    }
    section
        .paragraph(
            "The constants stay in the testbed's model: they belong to the experiment. On a gimbal that carries the \
             vehicle most of them do no harm.",
        )
        .table(table)
}
