//! The vehicles that ship with the page: the files of `models/`.

use sil_host::answer::SaidModel;
use sil_host::model::{Rig, VehicleModel};

use super::message;

/// A model file by its name.
pub(super) const MODELS: [(&str, &str); 7] = [
    ("f450-gimbal", include_str!("../../../models/f450-gimbal.toml")),
    ("generic-gimbal", include_str!("../../../models/generic-gimbal.toml")),
    ("box-gimbal", include_str!("../../../models/box-gimbal.toml")),
    ("f450-free", include_str!("../../../models/f450-free.toml")),
    ("generic-free", include_str!("../../../models/generic-free.toml")),
    ("box-free", include_str!("../../../models/box-free.toml")),
    ("crazyflie-free", include_str!("../../../models/crazyflie-free.toml")),
];

/// A model as the page names it: a name of [`MODELS`], or the text of a file.
pub(super) fn said_model(name_or_text: &str) -> Result<(String, SaidModel), String> {
    let (file, text) = match MODELS.iter().find(|(name, _)| *name == name_or_text) {
        Some((name, text)) => (format!("models/{name}.toml"), *text),
        None => ("model.toml".to_owned(), name_or_text),
    };
    let model = SaidModel::parse(text, &file).map_err(message)?;
    Ok((file, model))
}

/// A vehicle's model that ships, by its name.
pub(super) fn vehicle(name: &str) -> Result<VehicleModel, String> {
    match said_model(name)? {
        (_, SaidModel::Vehicle(model)) => Ok(*model),
        (file, SaidModel::Bench(_)) => Err(format!("{file}: a bench's model, here a vehicle's is needed")),
    }
}

/// A rig by its name.
pub(super) fn rig(name: &str) -> Result<Rig, String> {
    let found = Rig::NAMES.iter().find(|(known, _)| *known == name);
    found.map(|(_, rig)| *rig).ok_or_else(|| format!("no rig is called {name}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_vehicle_that_ships_is_read_and_named_after_its_rig() {
        for (name, _) in MODELS {
            let model = vehicle(name).unwrap();
            assert!(name.ends_with(model.rig().name()), "{name}");
        }
        let folder = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../models")).unwrap();
        let files = folder.filter(|file| file.as_ref().unwrap().path().extension().is_some_and(|e| e == "toml"));
        assert_eq!(files.count(), MODELS.len());
    }
}
