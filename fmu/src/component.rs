//! What an FMU holds: the plant, the plant with its IMU, or the control core, each made from a model.

use std::path::Path;

use sil_host::model::VehicleModel;

use crate::behaviour::{Behaviour, Refusal};
use crate::controller::Controller;
use crate::variable::Variable;
use crate::vehicle::Vehicle;

/// Where the model lies in an FMU's resources.
pub const MODEL_FILE: &str = "model.toml";

/// What is in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// The plant with ideal outputs.
    Plant,
    /// The same as it hangs in its rig, seen by its IMU.
    PlantWithImu,
    /// The control core.
    Controller,
}

impl Content {
    /// All of them.
    pub const ALL: [Content; 3] = [Content::Plant, Content::PlantWithImu, Content::Controller];

    /// How names of FMUs begin.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plant => "plant",
            Self::PlantWithImu => "plant_imu",
            Self::Controller => "controller",
        }
    }

    /// Can another integrator integrate it?
    pub fn is_for_model_exchange(self) -> bool {
        self == Self::Plant
    }

    /// What an importer hands back, so that description, resources and library are known to belong together.
    pub fn token(self, model_text: &str) -> String {
        format!("{}-{:016x}", self.name(), fnv_1a(model_text))
    }

    /// The content whose token this is.
    ///
    /// # Errors
    /// Where it is no token, or that of another model.
    fn from_token(token: &str, model_text: &str) -> Result<Self, Refusal> {
        let of_model = Self::ALL.into_iter().find(|content| content.token(model_text) == token);
        of_model.ok_or_else(|| format!("the token {token:?} does not belong to the model in the resources"))
    }
}

/// A number for a text: Fowler, Noll and Vo's hash 1a of 64 bits.
fn fnv_1a(text: &str) -> u64 {
    let mix = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    text.bytes().fold(0xcbf2_9ce4_8422_2325, mix)
}

/// One of the three, with its variables.
#[derive(Clone)]
pub struct Component {
    pub(crate) variables: Vec<Variable>,
    pub(crate) part: Part,
}

#[derive(Clone)]
#[expect(clippy::large_enum_variant, reason = "one an instance")]
pub(crate) enum Part {
    Vehicle(Vehicle),
    Controller(Controller),
}

impl Component {
    /// Of a model.
    pub fn new(content: Content, model: VehicleModel) -> Self {
        match content {
            Content::Controller => {
                let (controller, variables) = Controller::new(model);
                Self { variables, part: Part::Controller(controller) }
            }
            Content::Plant | Content::PlantWithImu => {
                let (vehicle, variables) = Vehicle::new(model, content == Content::PlantWithImu);
                Self { variables, part: Part::Vehicle(vehicle) }
            }
        }
    }

    /// From an FMU's resources.
    ///
    /// # Errors
    /// A model file that can't be used, with its place; a token of another FMU.
    pub(crate) fn load(resources: &Path, token: &str) -> Result<(Self, Content), Refusal> {
        let path = resources.join(MODEL_FILE);
        let shown = path.display().to_string();
        let text = std::fs::read_to_string(&path).map_err(|error| format!("{shown}: {error}"))?;
        let content = Content::from_token(token, &text)?;
        let model = VehicleModel::parse(&text, &shown).map_err(|error| error.to_string())?;
        Ok((Self::new(content, model), content))
    }

    /// Its variables, in the order of their value references.
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    pub(crate) fn behaviour(&mut self) -> &mut dyn Behaviour {
        match &mut self.part {
            Part::Vehicle(vehicle) => vehicle,
            Part::Controller(controller) => controller,
        }
    }

    /// What a foreign integrator may integrate.
    pub(crate) fn continuous(&mut self) -> Option<&mut Vehicle> {
        match &mut self.part {
            Part::Vehicle(vehicle) => Some(vehicle),
            Part::Controller(_) => None,
        }
    }
}
