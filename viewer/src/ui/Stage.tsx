/** The picture, and what is laid over it. */

import { useEffect, useRef } from "preact/hooks";
import { loading, noPicture, occluding, session } from "../engine/session";
import { wrapped } from "../material/parameters";
import { titleOf } from "../material/presets";
import { DIFFERENCE_SCALES, INITIAL, readView, type View } from "../state/state";
import { change, look, notice, state, task } from "../state/store";
import { Button } from "./Button";
import { Choice } from "./Choice";
import { valueByKey } from "./Slider";

/** The id of the picture's place. */
export const STAGE = "stage";

export function Stage() {
  const { comparison, materials, background } = state.value;
  const classes = background === "transparent" ? "stage checkered" : "stage";
  return (
    <section id={STAGE} class={classes} aria-label="Picture">
      <Picture />
      {(comparison === "side" || comparison === "swipe") && (
        <div class={`names ${comparison}`}>
          <span>A · {titleOf(materials[0])}</span>
          <span>B · {titleOf(materials[1])}</span>
        </div>
      )}
      {comparison === "swipe" && <Edge />}
      {comparison === "difference" && <Legend />}
      {noPicture.value === "" ? <Status /> : <p class="missing">{noPicture.value}</p>}
      <Told />
    </section>
  );
}

/** What went wrong. */
function Told() {
  if (notice.value === null) return null;
  const { text, retry } = notice.value;
  const close = () => {
    notice.value = null;
  };
  return (
    <div class="notice" role="alert">
      <span>{text}</span>
      {retry && (
        <Button
          onClick={() => {
            close();
            retry();
          }}
        >
          Try again
        </Button>
      )}
      <Button onClick={close}>Close</Button>
    </div>
  );
}

/** Where a pointer is that holds the picture [pixels]. */
type Place = readonly [number, number];

function Picture() {
  const canvas = useRef<HTMLCanvasElement>(null);
  const { current: held } = useRef(new Map<number, Place>());
  const present = session.value;
  useEffect(
    () => (canvas.current && present ? present.attach(canvas.current) : undefined),
    [present],
  );

  useEffect(() => {
    const element = canvas.current!;
    const wheel = (event: WheelEvent) => {
      event.preventDefault();
      // A pinch on a touchpad is a wheel with Ctrl, in small steps.
      const steps = event.deltaY * (event.ctrlKey ? 6 : 1);
      turn({ zoom: state.value.view.zoom * 2 ** (-steps / 600) });
    };
    element.addEventListener("wheel", wheel, { passive: false });
    return () => element.removeEventListener("wheel", wheel);
  }, []);

  const { object, mesh, environment, turntable, comparison, materials, active } = state.value;
  const named =
    comparison === "off"
      ? titleOf(materials[active])
      : `${titleOf(materials[0])} beside ${titleOf(materials[1])}`;
  useEffect(() => {
    if (!turntable) return undefined;
    const timer = setInterval(() => {
      if (wantsStillness()) look({ turntable: false });
      else if (held.size === 0) turn({ azimuth: state.value.view.azimuth + TURN });
    }, TURN_TIME);
    return () => clearInterval(timer);
  }, [turntable, held]);
  return (
    <canvas
      ref={canvas}
      tabIndex={0}
      role="img"
      aria-label={`${object === "own" ? mesh : `A ${object}`} of ${named}, lit by the environment “${environment}”. Arrow keys turn the camera, with Control they shift the picture, with Shift they turn the light; plus and minus zoom; Home or a double click resets the camera.`}
      onContextMenu={(event) => event.preventDefault()}
      onPointerDown={({ button, currentTarget, pointerId, clientX, clientY }) => {
        if (button === 1) return; // it scrolls
        currentTarget.setPointerCapture(pointerId);
        held.set(pointerId, [clientX, clientY]);
      }}
      onLostPointerCapture={({ pointerId }) => held.delete(pointerId)}
      onPointerMove={(event) => {
        const { pointerId, clientX, clientY, currentTarget } = event;
        const before = held.get(pointerId);
        if (before === undefined) return;
        const { view } = state.value;
        const [x, y] = [clientX - before[0], clientY - before[1]];
        held.set(pointerId, [clientX, clientY]);
        // The point under the pointer follows it.
        const follow = (share: number) => {
          const unit = (share * 2) / (currentTarget.clientHeight * view.zoom);
          return [view.pan[0] + x * unit, view.pan[1] - y * unit] as const;
        };
        const other = [...held].find(([id]) => id !== pointerId)?.[1];
        if (other !== undefined) {
          const apart = (at: Place) => Math.hypot(at[0] - other[0], at[1] - other[1]) + 1;
          const zoom = (view.zoom * apart([clientX, clientY])) / apart(before);
          turn({ zoom, pan: follow(0.5) }); // the middle of two pointers moves half as far
        } else if (event.buttons !== 1 || event.ctrlKey || event.metaKey) turn({ pan: follow(1) });
        else if (event.shiftKey) light(x * 0.4);
        else turn({ azimuth: view.azimuth - x * 0.4, elevation: view.elevation + y * 0.3 });
      }}
      onDblClick={() => look({ view: INITIAL.view })}
      onKeyDown={(event) => {
        const { view } = state.value;
        const hasControl = event.ctrlKey || event.metaKey;
        // With other keys they are the browser's: it goes back, and enlarges the page.
        if (event.altKey || (hasControl && !event.key.startsWith("Arrow"))) return;
        if (event.key === "Home") look({ view: INITIAL.view });
        const x = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
        const y = { ArrowUp: 1, ArrowDown: -1 }[event.key];
        const zoom = { "+": 1.1, "=": 1.1, "-": 1 / 1.1 }[event.key];
        const [along, upward] = view.pan;
        if ((x ?? y) !== undefined && hasControl)
          turn({ pan: [along + 0.1 * (x ?? 0), upward + 0.1 * (y ?? 0)] });
        else if (x !== undefined && event.shiftKey) light(5 * x);
        else if (x !== undefined) turn({ azimuth: view.azimuth + 5 * x });
        else if (y !== undefined) turn({ elevation: view.elevation + 5 * y });
        else if (zoom !== undefined) turn({ zoom: view.zoom * zoom });
        else return;
        event.preventDefault();
      }}
    />
  );
}

/** Angle and time of a step of the turntable [degrees, ms]: a turn takes 24 s. */
const [TURN, TURN_TIME] = [0.6, 40];

/** Whether the user's system asks for less motion, which the turntable heeds. */
export function wantsStillness(): boolean {
  return matchMedia("(prefers-reduced-motion: reduce)").matches;
}

/** Move the camera. */
function turn(change: Partial<View>): void {
  const { azimuth, pan, ...others } = { ...state.value.view, ...change };
  const shifts = pan.map((shift) => Number(shift.toFixed(3)));
  look({ view: readView({ ...others, azimuth: turned(azimuth), pan: shifts }) });
}

/** Turn the environment, which is a step of its own. */
function light(degrees: number): void {
  change({ rotation: turned(state.value.rotation + degrees) }, "rotation");
}

function turned(degrees: number): number {
  return Number(wrapped(degrees).toFixed(1));
}

function Status() {
  const painter = session.value?.painter;
  if (task.value !== null) {
    const { text, share, cancel } = task.value;
    return (
      <p class="status">
        <progress aria-label={text} value={share} />
        {text} …{cancel && <Button onClick={cancel}>Cancel</Button>}
      </p>
    );
  }
  if (painter === undefined) {
    const text = loading.value ? "Loading the networks …" : "The networks are not loaded.";
    return <p class="status">{text}</p>;
  }
  return (
    <p class="status" data-converged={painter.converged.value && !occluding.value}>
      <progress aria-hidden="true" value={painter.gathered.value} />
      {occluding.value ? "computing shadows" : painter.converged.value ? "converged" : "refining"}
    </p>
  );
}

/** What the colours of a difference mean. */
function Legend() {
  const { scale } = state.value;
  const found = session.value?.painter.difference.value;
  return (
    <div class="legend">
      <span title="Distance of the shown colours in CIELAB (CIE 1976); 2 is just seen">
        Colour difference
      </span>
      <span>0</span>
      <div class="ramp" aria-hidden="true" />
      <label>
        <span class="spoken">Largest difference</span>
        <Choice
          value={scale}
          options={DIFFERENCE_SCALES.map((value) => [value, value])}
          onChange={(value) => look({ scale: value })}
        />
      </label>
      {found && (
        <span title="Mean over the pixels that differ, and the largest difference">
          mean {found.mean.toFixed(1)}, largest {found.largest.toFixed(1)}
        </span>
      )}
    </div>
  );
}

/** Least share of the picture on either side of the edge. */
const LEAST_EDGE = 0.02;

/** The edge between the materials, which can be moved. */
function Edge() {
  const { edge } = state.value;
  return (
    <div
      class="edge"
      style={{ left: `${100 * edge}%` }}
      role="slider"
      tabIndex={0}
      aria-label="Edge between A and B"
      aria-orientation="horizontal"
      aria-valuemin={0}
      aria-valuemax={100}
      aria-valuenow={Math.round(100 * edge)}
      onPointerDown={(event) => event.currentTarget.setPointerCapture(event.pointerId)}
      onPointerMove={(event) => {
        if (!event.currentTarget.hasPointerCapture(event.pointerId)) return;
        const box = event.currentTarget.parentElement!.getBoundingClientRect();
        const place = (event.clientX - box.left) / box.width;
        look({ edge: Math.min(Math.max(place, LEAST_EDGE), 1 - LEAST_EDGE) });
      }}
      onKeyDown={(event) => {
        const next = valueByKey(event, edge, 0.02, LEAST_EDGE, 1 - LEAST_EDGE);
        if (next !== undefined) look({ edge: next });
      }}
    />
  );
}
