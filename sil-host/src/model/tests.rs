use super::*;

/// Every file under models/, which the embedded ones are among.
#[test]
fn every_model_file_reads_and_writes_back() {
    let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../models"));
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let model = VehicleModel::load(&path).unwrap();
        let again = VehicleModel::parse(&model.to_toml(), "written").unwrap();
        assert_eq!(model, again, "{}", path.display());
        count += 1;
    }
    assert_eq!(count, 6, "two rigs on three levels");
    assert_eq!(VehicleModel::nominal(Rig::Gimbal).rig(), Rig::Gimbal);
    assert_eq!(VehicleModel::nominal(Rig::Free).rig(), Rig::Free);
}
