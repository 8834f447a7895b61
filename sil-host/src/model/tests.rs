use super::*;

/// Every file under models/, which the embedded ones are among.
#[test]
fn every_model_file_reads_and_writes_back() {
    let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../models"));
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let model = VehicleModel::load(&path).unwrap();
        let again = VehicleModel::parse(&model.to_toml(), "written").unwrap();
        assert_eq!(model, again, "{}", path.display());
        names.push(format!("{} {}", model.level().name(), model.rig().name()));
    }
    names.sort();
    assert_eq!(
        names,
        ["box free", "box gimbal", "device free", "device gimbal", "generic free", "generic free", "generic gimbal"]
    );
    assert_eq!(VehicleModel::nominal(Rig::Gimbal).rig(), Rig::Gimbal);
    assert_eq!(VehicleModel::nominal(Rig::Free).rig(), Rig::Free);
}

#[test]
fn an_extended_model_writes_back_to_the_last_bit() {
    let mut model = VehicleModel::nominal(Rig::Gimbal);
    model.name = "with \"quotes\", a \\ and\na line break".to_owned();
    // numbers without a short decimal form, very small, and whole
    model.arm_m = 0.1 + 0.2;
    model.noise.gyro_rad_s = 5e-324_f64.max(1e-300);
    model.gravity_m_s2 = 10.0;
    model.effects.push(Effect::parse("cg_offset:axis=roll,cos_moment_nm=-3e-9,sin_moment_nm=1", Rig::Gimbal).unwrap());
    assert_eq!(VehicleModel::parse(&model.to_toml(), "written").unwrap(), model);
    // every effect of the catalogue that the rig can have, all at once
    for rig in [Rig::Gimbal, Rig::Free] {
        let mut model = VehicleModel::nominal(rig);
        let entries = Effect::CATALOGUE.iter().filter(|entry| entry.rigs.contains(&rig));
        model.effects = entries.map(|entry| Effect::parse(entry.example, rig).unwrap()).collect();
        assert!(model.effects.len() >= 19);
        assert_eq!(VehicleModel::parse(&model.to_toml(), "written").unwrap(), model);
    }
}

/// The thesis' numbers, typed a second time.
#[test]
fn the_gimbal_model_holds_the_numbers_of_the_thesis() {
    let model = VehicleModel::nominal(Rig::Gimbal);
    assert_eq!(model.inertia_kg_m2, [0.0115118, 0.0115118, 0.020]);
    assert_eq!(model.mounting, Mounting::Gimbal { ring_inertia_kg_m2: 0.0250533 });
    assert_eq!((model.arm_m, model.base_command, model.gravity_m_s2), (0.226, 0.5, 9.81));
    assert_eq!(
        model.noise,
        SensorNoise { gyro_rad_s: 0.01, accel_m_s2: 0.1, attitude_rad: 0.002, velocity_m_s: 0.05, height_m: 0.02 }
    );
    assert!(model.effects.is_empty());
    let Propulsion::Device(device) = model.propulsion else { panic!("{:?}", model.propulsion) };
    assert_eq!((device.resistance_ohm, device.inductance_h), (0.127, 1.6968e-4));
    assert_eq!((device.speed_constant_rad_s_v, device.speed_offset_rad_s), (70.93, -213.76));
    assert_eq!((device.loss_nm_s, device.drag_nm_s2), (4.4528e-6, 2.0066e-8));
    assert_eq!((device.motor_inertia_kg_m2, device.rotor_inertia_kg_m2), (3.38e-7, 2.8e-6));
    assert_eq!((device.lift_n_s2, device.reaction_torque_nm_s2), (1.5064e-6, 5.6977e-8));
}

#[test]
fn the_free_model_can_fly() {
    let model = VehicleModel::nominal(Rig::Free);
    let Mounting::Free { mass_kg } = model.mounting else { panic!("{:?}", model.mounting) };
    let weight_n = mass_kg * model.gravity_m_s2;
    assert!((4.0 * model.propulsion.lift_n(model.base_command) / weight_n - 1.0).abs() < 1e-7);
    assert!((0.45..0.6).contains(&model.base_command));
    // twice the weight is the usual rule, three times the usual maximum
    let reserve = 4.0 * model.propulsion.lift_n(1.0) / weight_n;
    assert!((2.0..3.5).contains(&reserve), "{reserve}");
}

/// The gimbal's file with one line replaced.
fn broken(line: &str, replacement: &str) -> String {
    let text = include_str!("../../../models/f450-gimbal.toml");
    let found = text.lines().filter(|candidate| candidate.starts_with(line)).count();
    assert_eq!(found, 1, "{line}");
    let lines = text.lines().map(|candidate| if candidate.starts_with(line) { replacement } else { candidate });
    lines.collect::<Vec<_>>().join("\n")
}

/// Where a text is wrong, and how.
fn complaint(text: &str) -> (usize, usize, Problem) {
    match VehicleModel::parse(text, "x.toml") {
        Err(ModelError::Invalid { file, position, problem }) => {
            assert_eq!(file, "x.toml");
            (position.line, position.column, problem)
        }
        other => panic!("expected a complaint, got {other:?}"),
    }
}

/// Number of the line of the gimbal's file that starts so.
fn line_of(start: &str) -> usize {
    let text = include_str!("../../../models/f450-gimbal.toml");
    1 + text.lines().position(|line| line.starts_with(start)).unwrap()
}

#[test]
fn a_wrong_number_is_named_with_its_place_and_range() {
    // (line, what stands there instead, column of the value): slips of unit, sign, and no number at all
    for (line, replacement, column) in [
        ("arm_m", "arm_m = 226", 9),
        ("arm_m", "arm_m = nan", 9),
        ("gravity_m_s2", "gravity_m_s2 = inf", 16),
        ("ixx_kg_m2", "ixx_kg_m2 = -0.0115118", 13),
        ("iyy_kg_m2", "iyy_kg_m2 = 115.118", 13),
        ("base_command", "base_command = 50", 16),
        ("gyro_rad_s", "gyro_rad_s = -0.01", 14),
        ("resistance_ohm", "resistance_ohm =  127", 19),
        ("lift_n_s2", "lift_n_s2 = 0.0", 13),
        ("speed_constant_rad_s_v", "speed_constant_rad_s_v = 0", 26),
    ] {
        let (at_line, at_column, problem) = complaint(&broken(line, replacement));
        assert_eq!((at_line, at_column), (line_of(line), column), "{replacement}");
        let Problem::OutOfRange { key, expected, .. } = problem else { panic!("{replacement}: {problem:?}") };
        assert_eq!(key, line);
        assert!(expected.contains(" to "), "{expected}");
    }
}

#[test]
fn a_wrong_key_or_type_is_named_with_its_place() {
    let cases = [
        (broken("arm_m", "arm_mm = 226"), "lacks `arm_m`"),
        (broken("arm_m", "arm_m = \"0.226\""), "`arm_m` is of type string"),
        (broken("arm_m", "arm_m = 0.226\nwheels = 4"), "unknown key `wheels` in the model"),
        (broken("loss_nm_s", "loss_nm_s = 4.4528e-6\nloss = 1.0"), "unknown key `loss` in [propulsion.motor]"),
        (broken("rig", "rig = \"test stand\""), "expected \"gimbal\" or \"free\""),
        (broken("level", "level = \"specific\""), "expected \"box\" or \"generic\" or \"device\""),
        (broken("level", "level = 3"), "`level` is of type integer"),
        (broken("map", "map = \"linear\""), "expected \"exponential\" or \"duty\""),
        (broken("[noise]", "[nose]"), "lacks `noise`"),
        (broken("rig", "rig = \"free\""), "[body] lacks `mass_kg`"),
        (broken("resistance_ohm", ""), "[propulsion.motor] lacks `resistance_ohm`"),
        (broken("name", "name = "), "not valid TOML"),
        (broken("name", "name = \"a\"\nname = \"b\""), "not valid TOML"),
        (String::new(), "lacks `name`"),
    ];
    for (text, expected) in cases {
        let (line, column, problem) = complaint(&text);
        assert!(problem.to_string().contains(expected), "{problem}");
        assert!(line >= 1 && column >= 1 && line <= text.lines().count() + 1);
    }
    // the places that matter most: the misspelt key, the table that lacks one
    let (line, column, _) = complaint(&broken("loss_nm_s", "loss_nm_s = 4.4528e-6\n  loss = 1.0"));
    assert_eq!((line, column), (line_of("loss_nm_s") + 1, 3));
    let (line, ..) = complaint(&broken("resistance_ohm", ""));
    assert_eq!(line, line_of("[propulsion.motor]"));
}

#[test]
fn an_impossible_body_is_refused() {
    let (line, _, problem) = complaint(&broken("izz_kg_m2", "izz_kg_m2 = 0.024"));
    assert_eq!(line, line_of("[body]"));
    assert!(matches!(problem, Problem::Impossible(_)), "{problem:?}");
    assert!(problem.to_string().contains("0.024"), "{problem}");
    // a flat plate is the limit
    assert!(VehicleModel::parse(&broken("izz_kg_m2", "izz_kg_m2 = 0.0230236"), "flat").is_ok());
}

#[test]
fn a_wrong_effect_is_named_with_its_place() {
    let with_effect = |effect: &str| include_str!("../../../models/f450-gimbal.toml").to_owned() + "\n" + effect;
    let last = with_effect("").lines().count();
    let cases = [
        ("[[effect]]\nname = \"gravity\"", 2, "expected \"cg_offset\""),
        ("[[effect]]\nname = \"cg_offset\"", 1, "[[effect]] lacks `axis`"),
        ("[[effect]]\nname = \"cg_offset\"\naxis = \"yaw\"", 3, "expected \"roll\" or \"pitch\""),
        ("[[effect]]\nname = \"cg_offset\"\naxis = \"roll\"\ncos_moment_nm = 100", 4, "moment when level in N m"),
        (
            "[[effect]]\nname = \"cg_offset\"\naxis = \"roll\"\ncos_moment_nm = 1\nmass_kg = 1",
            5,
            "unknown key `mass_kg`",
        ),
        ("[[effect]]\nname = \"weak_motor\"\nscale = 0.9\nmotor = 2.5", 4, "`motor` is 2.5"),
        ("[[effect]]\nname = \"spring\"\naxis = \"roll\"\nstifness_nm_rad = 1", 1, "lacks `stiffness_nm_rad`"),
        ("[[effect]]\nname = \"wind\"", 1, "wind has no meaning on the rig gimbal"),
        ("[[effect]]\nname = \"inertia_coupling\"\nproduct_kg_m2 = 0.0116", 1, "no body has the product"),
        ("[effect]\nname = \"cg_offset\"", 1, "expected tables headed [[effect]]"),
    ];
    for (effect, line, expected) in cases {
        let (at_line, _, problem) = complaint(&with_effect(effect));
        assert_eq!(at_line, last + line, "{effect}: {problem}");
        assert!(problem.to_string().contains(expected), "{problem}");
    }
}

#[test]
fn a_file_that_cannot_be_read_is_named() {
    let error = VehicleModel::load("no/such/model.toml".as_ref()).unwrap_err();
    assert!(error.to_string().starts_with("no/such/model.toml: cannot read the model"), "{error}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("binary.toml");
    std::fs::write(&path, [0xff, 0xfe, 0x00]).unwrap();
    let error = VehicleModel::load(&path).unwrap_err();
    assert!(error.to_string().contains("binary.toml: cannot read the model"), "{error}");
}

proptest::proptest! {
    /// Whatever stands in the file, reading it ends in a model or in a complaint.
    #[test]
    fn reading_never_panics(cut in 0..2000_usize, noise in "\\PC{0,40}") {
        let text = include_str!("../../../models/f450-free.toml");
        let cut = text.char_indices().map(|(index, _)| index).nth(cut).unwrap_or(text.len());
        let _ = VehicleModel::parse(&text[..cut], "cut");
        let _ = VehicleModel::parse(&(text[..cut].to_owned() + &noise + &text[cut..]), "noisy");
        let _ = Effect::parse(&noise, Rig::Free);
    }
}
