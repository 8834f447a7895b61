//! `sil refine`: a model's constants from bench measurements, and whether a model can be.

use std::path::PathBuf;

use clap::Args;
use sil_host::answer::refinement::{RefinedJson, checks_text, page, text};
use sil_host::model::{Mounting, VehicleModel};
use sil_host::refinement::{Bench, Given, Order, checks, refine};
use sil_host::vehicle::propulsion::Propulsion;

use super::{Failure, bad_input, print, to_stdout, vehicle_model, write_file, write_json};

/// Measure a model's constants on a bench: speed controller, motor, propeller, each with its interval; check that they
/// can be
#[derive(Args)]
#[command(after_help = "Example: sil refine esc.csv motor.csv rotor.csv --model models/f450-free.toml -o mine.toml\n\
Example: sil refine stand.csv --diameter 0.178 --form lift=table --report out/stand.html\n\
Example: sil refine --model models/f450-gimbal.toml --diameter 0.254 --mass 1.2 --kv 920 --supply 12.6\n\n\
Columns name their units (command, motor_v, current_a, speed_rad_s, lift_n, torque_nm, ...); each file gives what its\n\
columns show. Without a file the constants of the model itself are checked. docs/refine.md explains it.")]
pub struct RefineArguments {
    /// Bench measurements: CSV, compressed by gzip or not
    #[arg(value_name = "BENCH.csv")]
    benches: Vec<PathBuf>,
    /// The model whose constants are replaced where they were measured; the others stay [default: the F450 on the
    /// gimbal]
    #[arg(long, value_name = "MODEL.toml")]
    model: Option<PathBuf>,
    /// Take this form of a component, such as lift=table or esc=exponential, instead of the one that predicts best
    #[arg(long, value_name = "COMPONENT=FORM")]
    form: Vec<String>,
    /// Measurements that no fit uses: the error of every form is reported on them. May be given several times
    #[arg(long, value_name = "BENCH.csv")]
    held_out: Vec<PathBuf>,
    /// The propeller's diameter, m, for the checks
    #[arg(long, value_name = "M")]
    diameter: Option<f64>,
    /// The vehicle's mass, kg, for the checks [default: the model's, if it flies free]
    #[arg(long, value_name = "KG")]
    mass: Option<f64>,
    /// The motor's rated speed constant, rpm/V, for the checks
    #[arg(long, value_name = "RPM_V")]
    kv: Option<f64>,
    /// The supply's highest voltage, V, for the checks
    #[arg(long, value_name = "V")]
    supply: Option<f64>,
    /// Write the model here instead of on the terminal
    #[arg(short, long, value_name = "OUT.toml")]
    out: Option<PathBuf>,
    /// Write a page with readings, forms and residuals
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,
    /// Write the numbers as JSON
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
}

pub fn run(arguments: &RefineArguments) -> Result<(), Failure> {
    let base = vehicle_model(arguments.model.as_deref(), None)?;
    let given = given(arguments, &base)?;
    if arguments.benches.is_empty() {
        return check_only(arguments, &base, &given);
    }
    let read = |paths: &[PathBuf]| paths.iter().map(|path| Bench::load(path)).collect::<Result<Vec<_>, _>>();
    let benches = read(&arguments.benches).map_err(bad_input)?;
    let held_out = read(&arguments.held_out).map_err(bad_input)?;
    let order = Order { given, forms: &arguments.form, held_out: &held_out };
    let refined = refine(&benches, &base, &order).map_err(bad_input)?;
    match &arguments.out {
        Some(out) => {
            print(text(&refined))?;
            write_file(out, refined.to_toml().as_bytes())?;
            print(format!("\nmodel           {}\n", out.display()))?;
        }
        // the model is the result, unless its numbers or its page were requested
        None if arguments.json.is_none() && arguments.report.is_none() => to_stdout(refined.to_toml())?,
        None => print(text(&refined))?,
    }
    if let Some(report) = &arguments.report {
        let command = std::env::args().skip(1).fold("sil".to_owned(), |line, word| line + " " + &word);
        write_file(report, page(&refined, &command).to_html().as_bytes())?;
        print(format!("report          {}\n", report.display()))?;
    }
    write_json(arguments.json.as_deref(), &RefinedJson::of(&refined))
}

/// The model's own constants, without a bench.
fn check_only(arguments: &RefineArguments, base: &VehicleModel, given: &Given) -> Result<(), Failure> {
    let output = [&arguments.out, &arguments.report].into_iter().flatten().next();
    if let Some(path) = output {
        return Err(bad_input(format!("{}: nothing to write: expected bench measurements", path.display())));
    }
    let Propulsion::Device(device) = base.propulsion else {
        return Err(bad_input(format!(
            "the model is of level {}: expected level device, which has the constants that are checked",
            base.propulsion.level().name()
        )));
    };
    let checks = checks(&device, given, base.gravity_m_s2);
    print(format!("{}\n{}", base.name, checks_text(&checks)))?;
    write_json(arguments.json.as_deref(), &serde_json::json!({ "checks": checks }))
}

/// What the checks know beside the constants.
fn given(arguments: &RefineArguments, base: &VehicleModel) -> Result<Given, Failure> {
    let of = |name: &str, value: Option<f64>| match value {
        Some(value) if !(value.is_finite() && value > 0.0) => {
            Err(bad_input(format!("--{name} {value}: expected a number above 0")))
        }
        value => Ok(value),
    };
    let mass_kg = match base.mounting {
        Mounting::Free { mass_kg } => Some(mass_kg),
        Mounting::Gimbal { .. } => None,
    };
    Ok(Given {
        diameter_m: of("diameter", arguments.diameter)?,
        mass_kg: of("mass", arguments.mass)?.or(mass_kg),
        kv_rpm_v: of("kv", arguments.kv)?,
        supply_v: of("supply", arguments.supply)?,
    })
}
