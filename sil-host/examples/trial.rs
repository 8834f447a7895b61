use sil_host::{diagnosis, log, model};
fn main() {
    for path in std::env::args().skip(1) {
        println!("== {path}");
        let log = log::read(path.as_ref(), None).unwrap();
        diagnosis::trial(&log, &diagnosis::Subject::Vehicle(&model::VehicleModel::nominal(model::Rig::Gimbal)))
            .unwrap();
    }
}
