/**
 * What the studio and its page tell each other, as JSDoc types; this module has no code. Point lists are flat, in the
 * shape's frame, y upwards; angles are radians. The Python side is studio/scene.py and studio/messages.py.
 *
 * @typedef {'p' | 'q'} Side
 * @typedef {number[]} Flat x0, y0, x1, y1, …
 * @typedef {[number, number]} Point
 *
 * @typedef {object} Piece
 * @property {number} length
 * @property {Flat} outline in the piece's frame; the first `lower` points are P's arc, the others are Q's
 * @property {number} lower
 * @property {number} colour
 *
 * @typedef {object} Motion
 * @property {boolean} planned
 * @property {string} words
 * @property {number} open
 * @property {number[]} lifted
 * @property {number[]} order
 * @property {number[]} times
 * @property {number[][]} headings
 * @property {number[][]} middles
 * @property {number[][]} levels
 *
 * @typedef {{iou: number, strain: number, lost: Flat, words: string}} Fidelity `lost`: middles of limbs, on the bent input
 *
 * @typedef {object} ShapeScene
 * @property {string} name
 * @property {Flat} input
 * @property {Flat | null} bent
 * @property {Flat} trunk
 * @property {Flat} feet
 * @property {Fidelity} fidelity
 *
 * @typedef {object} Scene
 * @property {string} id
 * @property {boolean} exact
 * @property {Piece[]} pieces
 * @property {Motion} motion
 * @property {ShapeScene} p
 * @property {ShapeScene} q
 * @property {string} words
 * @property {{passed: boolean, words: string}} certificate
 *
 * @typedef {{name: string, outline: Flat, shape?: number | null, colours?: boolean}} Input
 * @typedef {{href: string, box: [number, number, number, number]}} Texture x0, y0, x1, y1 in the piece's frame
 * @typedef {{kind: 'keep' | 'draw', points: Flat}} Pin
 * @typedef {{polygon: Flat, factor: number}} StiffRegion
 * @typedef {{name: string, transform: string, words: string}} Snapshot
 *
 * @typedef {object} Session
 * @property {string} id
 * @property {number} revision
 * @property {string | null} undo
 * @property {string | null} redo
 * @property {Input | null} p
 * @property {Input | null} q
 * @property {[number | null, number | null] | null} pieces
 * @property {number | null} weight
 * @property {{p: Pin[], q: Pin[]}} pins
 * @property {{p: StiffRegion[], q: StiffRegion[]}} stiff
 * @property {string | null} transform
 * @property {Snapshot[]} snapshots
 * @property {boolean} collection
 * @property {boolean} saved
 *
 * @typedef {object} Problem
 * @property {number} seq
 * @property {boolean} draft
 * @property {Side | null} side
 * @property {Flat} where
 * @property {number | null} pin
 * @property {string} words
 *
 * @typedef {object} Alternative
 * @property {number} rank
 * @property {string} transform
 * @property {number} pieces
 * @property {number} worth the greater the better
 * @property {string} words
 * @property {Scene} scene
 *
 * @typedef {{shape: number, qcrs: number, scene?: Scene}} Partner
 *
 * @typedef {object} Finding
 * @property {'failure' | 'warning' | 'fact'} severity
 * @property {number | null} piece
 * @property {number | null} hinge
 * @property {string} words
 * @property {string | null} parameter
 * @property {number | null} value
 *
 * @typedef {object} Part
 * @property {string} name
 * @property {'piece' | 'pin' | 'sleeve'} kind
 * @property {number | null} piece
 * @property {number} count
 * @property {number[]} size_mm
 * @property {boolean} upside_down whether its STL file is turned over
 * @property {string} url
 *
 * @typedef {object} Made
 * @property {string} transform
 * @property {string} key
 * @property {boolean} passed
 * @property {string[]} changes
 * @property {number} scale
 * @property {number} thickness
 * @property {Finding[]} findings
 * @property {Part[]} parts
 *
 * @typedef {object} Setting
 * @property {string} name
 * @property {number | boolean | string} value
 * @property {number | null} least
 * @property {number | null} greatest
 * @property {string[]} choices of a word
 * @property {string} unit
 * @property {string} meaning
 *
 * @typedef {{kind: string, [name: string]: unknown}} Edit
 */

export {};
