//! What a picture is made from: so that only what belongs together is put together.

/// The scene and the settings that decide every bit of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recipe {
    /// The name of the scene, for people; two names of one scene are no difference.
    pub name: String,
    /// SHA-256 of what the scene says, and of all that it refers to.
    pub scene: [u8; 32],
    /// The samples in each pixel of the finished picture.
    pub spp: u32,
    /// Everything else, as names and values: version, seed, depth, filter, ...
    pub settings: Vec<(String, String)>,
}

impl Recipe {
    /// In what `other` differs, in words; `None` if both make the same picture.
    pub fn difference(&self, other: &Self) -> Option<String> {
        if self.scene != other.scene {
            return Some("it is of another scene, or the scene has been changed".to_owned());
        }
        if self.spp != other.spp {
            return Some(format!("it is for {} samples in a pixel, not {}", other.spp, self.spp));
        }
        let value = |of: &Self, key: &str| {
            of.settings.iter().find(|(k, _)| k == key).map_or("none".to_owned(), |(_, v)| v.clone())
        };
        let keys = self.settings.iter().chain(&other.settings).map(|(key, _)| key);
        keys.map(|key| (key, value(self, key), value(other, key)))
            .find(|(_, ours, theirs)| ours != theirs)
            .map(|(key, ours, theirs)| format!("its {key} is {theirs}, not {ours}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_told() {
        let pair = |k: &str, v: &str| (k.to_owned(), v.to_owned());
        let recipe = Recipe {
            name: "a.toml".to_owned(),
            scene: [7; 32],
            spp: 16,
            settings: vec![pair("seed", "1"), pair("filter", "box 0.5")],
        };
        assert_eq!(
            recipe.difference(&Recipe { name: "b.toml".to_owned(), ..recipe.clone() }),
            None
        );
        let told = |other: &Recipe| recipe.difference(other).unwrap();
        assert!(told(&Recipe { scene: [8; 32], ..recipe.clone() }).contains("another scene"));
        assert!(told(&Recipe { spp: 4, ..recipe.clone() }).contains("for 4 samples"));
        let mut other = recipe.clone();
        other.settings[0].1 = "2".to_owned();
        assert_eq!(told(&other), "its seed is 2, not 1");
        other = recipe.clone();
        other.settings.push(pair("section", "x"));
        assert_eq!(told(&other), "its section is x, not none");
        other.settings.truncate(1);
        assert_eq!(told(&other), "its filter is none, not box 0.5");
    }
}
