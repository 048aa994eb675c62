/** How the picture is seen: lens, background, tone curve, turntable, and full screen. */

import { Refusal } from "../refusal";
import { INITIAL, TONES, type Tone } from "../state/state";
import { change, complain, look, state } from "../state/store";
import { Button } from "./Button";
import { Choice } from "./Choice";
import { Dial } from "./Dial";
import { STAGE, wantsStillness } from "./Stage";

const TONE_NAMES: Record<Tone, string> = {
  neutral: "Neutral (Khronos)",
  filmic: "Filmic (ACES)",
  none: "None (sRGB)",
};

const BACKGROUNDS = { environment: "Environment", colour: "Colour", transparent: "Transparent" };

/** The first plain background, that of catalogues. */
const PLAIN = "#f2f2f2";

export function ViewMenu({ onDone }: { onDone: () => void }) {
  const { view, background, tone, turntable } = state.value;
  const isColour = background.startsWith("#");
  const fullScreen = async () => {
    onDone();
    try {
      await document.getElementById(STAGE)!.requestFullscreen();
    } catch {
      complain(new Refusal("The browser does not let the page fill the screen."));
    }
  };
  return (
    <>
      <Dial
        label="Field of view"
        hint="Angle of the lens; the object keeps its size. Double click: reset."
        text={`${view.fov}°`}
        value={view.fov}
        low={5}
        high={60}
        step={1}
        fallback={INITIAL.view.fov}
        onInput={(fov) => look({ view: { ...state.value.view, fov } })}
      />
      <label>
        <span>Background</span>
        <Choice
          value={isColour ? "colour" : background}
          options={Object.entries(BACKGROUNDS)}
          onChange={(value) => change({ background: value === "colour" ? PLAIN : value })}
        />
        {isColour && (
          <input
            type="color"
            class="swatch"
            aria-label="Colour of the background"
            value={background}
            onInput={(event) => change({ background: event.currentTarget.value }, "background")}
          />
        )}
      </label>
      <label>
        <span>Tone curve</span>
        <Choice
          value={tone}
          options={TONES.map((name) => [name, TONE_NAMES[name]])}
          onChange={(value) => change({ tone: value })}
        />
      </label>
      <label title={wantsStillness() ? "Your system asks for less motion." : undefined}>
        <span>Turntable</span>
        <input
          type="checkbox"
          checked={turntable}
          disabled={wantsStillness()}
          onChange={(event) => look({ turntable: event.currentTarget.checked })}
        />
      </label>
      <div class="pair">
        <Button class="text-button" onClick={() => look({ view: INITIAL.view })}>
          Reset camera
        </Button>
        {document.fullscreenEnabled && (
          <Button class="text-button" onClick={() => void fullScreen()}>
            Full screen
          </Button>
        )}
      </div>
    </>
  );
}
