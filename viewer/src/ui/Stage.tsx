/** The picture, and what is laid over it. */

import { useEffect, useRef } from "preact/hooks";
import { encoding } from "../engine/open";
import { loading, noPicture, occluding, session } from "../engine/session";
import { titleOf } from "../material/presets";
import { DIFFERENCE_SCALES, INITIAL, type View } from "../state/state";
import { change, look, notice, state } from "../state/store";

export function Stage() {
  const { comparison, materials } = state.value;
  return (
    <section class="stage" aria-label="Picture">
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
        <button
          type="button"
          onClick={() => {
            close();
            retry();
          }}
        >
          Try again
        </button>
      )}
      <button type="button" onClick={close}>
        Close
      </button>
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

  const { object, mesh, environment } = state.value;
  return (
    <canvas
      ref={canvas}
      tabIndex={0}
      role="img"
      aria-label={`${object === "own" ? mesh : `A ${object}`} of the material, lit by the environment “${environment}”. Arrow keys turn the camera, plus and minus zoom, Home or a double click resets it, with Shift the arrow keys turn the light.`}
      onPointerDown={({ button, currentTarget, pointerId, clientX, clientY }) => {
        if (button !== 0) return;
        currentTarget.setPointerCapture(pointerId);
        held.set(pointerId, [clientX, clientY]);
      }}
      onLostPointerCapture={({ pointerId }) => held.delete(pointerId)}
      onPointerMove={({ pointerId, clientX, clientY, shiftKey }) => {
        const before = held.get(pointerId);
        if (before === undefined) return;
        const { view } = state.value;
        const [x, y] = [clientX - before[0], clientY - before[1]];
        held.set(pointerId, [clientX, clientY]);
        const other = [...held].find(([id]) => id !== pointerId)?.[1];
        if (other !== undefined) {
          const apart = (at: Place) => Math.hypot(at[0] - other[0], at[1] - other[1]) + 1;
          turn({ zoom: (view.zoom * apart([clientX, clientY])) / apart(before) });
        } else if (shiftKey) light(x * 0.4);
        else turn({ azimuth: view.azimuth - x * 0.4, elevation: view.elevation + y * 0.3 });
      }}
      onDblClick={() => look({ view: INITIAL.view })}
      onKeyDown={(event) => {
        const { view } = state.value;
        if (event.key === "Home") look({ view: INITIAL.view });
        const x = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
        const y = { ArrowUp: 1, ArrowDown: -1 }[event.key];
        const zoom = { "+": 1.1, "=": 1.1, "-": 1 / 1.1 }[event.key];
        if (x !== undefined && event.shiftKey) light(5 * x);
        else if (x !== undefined) turn({ azimuth: view.azimuth + 5 * x });
        else if (y !== undefined) turn({ elevation: view.elevation + 5 * y });
        else if (zoom !== undefined) turn({ zoom: view.zoom * zoom });
        else return;
        event.preventDefault();
      }}
    />
  );
}

/** Move the camera. */
function turn(change: Partial<View>): void {
  const view = { ...state.value.view, ...change };
  look({
    view: {
      azimuth: around(view.azimuth),
      elevation: Math.min(Math.max(view.elevation, -5), 80),
      zoom: Math.min(Math.max(view.zoom, 0.5), 4),
    },
  });
}

/** Turn the environment, which is a step of its own. */
function light(degrees: number): void {
  const rotation = around(state.value.rotation + degrees);
  change({ ...state.value, rotation }, "rotation");
}

function around(degrees: number): number {
  return Number((((((degrees + 180) % 360) + 360) % 360) - 180).toFixed(1));
}

function Status() {
  const painter = session.value?.painter;
  if (encoding.value) return <p class="status">Encoding the measured BRDF …</p>;
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
        <select
          value={scale}
          onChange={(event) => look({ scale: Number(event.currentTarget.value) })}
        >
          {DIFFERENCE_SCALES.map((value) => (
            <option key={value} value={value}>
              {value}
            </option>
          ))}
        </select>
      </label>
      {found && (
        <span title="Mean over the pixels that differ, and the largest difference">
          mean {found.mean.toFixed(1)}, largest {found.largest.toFixed(1)}
        </span>
      )}
    </div>
  );
}

/** The edge between the materials, which can be moved. */
function Edge() {
  const { edge } = state.value;
  const set = (value: number) => look({ edge: Math.min(Math.max(value, 0.02), 0.98) });
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
        set((event.clientX - box.left) / box.width);
      }}
      onKeyDown={(event) => {
        const step = { ArrowLeft: -0.02, ArrowRight: 0.02 }[event.key];
        if (step === undefined) return;
        event.preventDefault();
        set(edge + step);
      }}
    />
  );
}
